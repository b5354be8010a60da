// SPDX-License-Identifier: Apache-2.0
// Base64 (RFC 4648, section 4), as data URIs have it.
#pragma once

#include <optional>
#include <string>

namespace multum {

std::string encode_base64(const std::string& bytes);

/// Up to the first '='; nullopt where another character is none of the 64 digits.
std::optional<std::string> decode_base64(const std::string& text);

}  // namespace multum
