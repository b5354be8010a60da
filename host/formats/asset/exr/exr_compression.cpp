// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/exr/exr_compression.h"

#include <map>
#include <optional>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"

namespace multum {

namespace {

std::optional<ExrCompression> find_compression(const std::string& text) {
  static const std::map<std::string, Imf::Compression> kNames = {{"none", Imf::NO_COMPRESSION},
                                                                 {"rle", Imf::RLE_COMPRESSION},
                                                                 {"zips", Imf::ZIPS_COMPRESSION},
                                                                 {"zip", Imf::ZIP_COMPRESSION},
                                                                 {"piz", Imf::PIZ_COMPRESSION}};
  const std::size_t colon = text.find(':');
  const auto found = kNames.find(text.substr(0, colon));
  int level = -1;
  if (colon != std::string::npos) {
    const std::string digits = text.substr(colon + 1);
    if (digits.size() == 1 && digits[0] >= '1' && digits[0] <= '9') level = digits[0] - '0';
  }
  const bool level_ok = colon == std::string::npos || (level > 0 && text.rfind("zip", 0) == 0);
  if (found == kNames.end() || !level_ok) return std::nullopt;
  return ExrCompression{found->second, level};
}

}  // namespace

ExrCompression parse_compression(const std::string& text) {
  const std::optional<ExrCompression> found = find_compression(text);
  if (!found) throw Error(ErrorCode::kUsage, "compression '" + text + "' is unknown; expected " + kCompressionsInWords);
  return *found;
}

void validate(const BakedWriteOptions& options) { parse_compression(options.compression); }

}  // namespace multum
