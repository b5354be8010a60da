// SPDX-License-Identifier: Apache-2.0
// The checksum of a baked file's headers (docs/reference/file_format.md, "Header checksum"). The checksum of pixels
// covers no attribute. Without this checksum, damage to an attribute (the sharpest kappa, the source's hash, the
// measured errors) would not be noticed. Only host/formats/asset uses this file.
#pragma once

#include <string>

#include "host/formats/asset/baked_verify.h"

namespace multum {

// The attribute is only in the first part, because it covers all parts.
constexpr char kHeaderHashAttribute[] = "multum:headerHash";
// The room for the text of the checksum. The text has 64 digits, and 10 bytes plus the name for each attribute. A file
// of lobes needs 880 bytes.
constexpr int kHeaderHashBytes = 2048;

/// Returns the text for the attribute, computed from the file's headers. Throws Error(kInput) if the headers are cut
/// short.
std::string header_hash_text(const std::string& path);

/// Compares the headers with the attribute. The finding passes if they match, or if an older file lacks the attribute.
/// Otherwise, the finding names the attributes that have changed. Throws like header_hash_text().
VerifyFinding header_finding(const std::string& path);

}  // namespace multum
