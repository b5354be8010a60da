// SPDX-License-Identifier: Apache-2.0
// Decodes Base64 (RFC 4648, section 4), the encoding of data URIs.
#pragma once

#include <optional>
#include <string>

namespace multum {

std::string encode_base64(const std::string& bytes);

/// Decodes the characters before the first '='. Returns nullopt if any of them is not one of the 64 digits of Base64.
std::optional<std::string> decode_base64(const std::string& text);

}  // namespace multum
