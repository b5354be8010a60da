// SPDX-License-Identifier: Apache-2.0
// The checksum of a baked file's headers: that of its pixels covers no attribute, and an attribute with other values
// (the sharpest kappa, the source's hash, the measured errors) would be believed. docs/reference/file_format.md,
// "Header checksum", describes it. For host/formats/asset alone.
#pragma once

#include <string>

#include "host/formats/asset/baked_verify.h"

namespace multum {

// In the first part alone: it is of all parts.
constexpr char kHeaderHashAttribute[] = "multum:headerHash";
// Room for its text: 64 digits, and for each attribute its name and 10 bytes; a file of lobes takes 880.
constexpr int kHeaderHashBytes = 2048;

/// Text that the attribute has to hold, by the file's headers as they are. Throws Error(kInput) where they are cut.
std::string header_hash_text(const std::string& path);

/// Passed when the headers are as the attribute says, and when there is none: files written before it was there. Names
/// the attributes that are not. Throws as header_hash_text() does.
VerifyFinding header_finding(const std::string& path);

}  // namespace multum
