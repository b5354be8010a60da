// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/representation.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {

const char* storage_encoding_name(StorageEncoding encoding) {
  switch (encoding) {
    case StorageEncoding::kSnorm16: return "snorm16";
    case StorageEncoding::kHalf: return "half";
    case StorageEncoding::kFloat: return "float";
  }
  return "?";
}

const std::vector<RepresentationInfo>& representations() {
  static const std::vector<RepresentationInfo> all = {
      {Representation::kMovmf,
       "vmf",
       "movmf",
       3,
       {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat},
       "lobes (Han 2007), the most accurate"},
      {Representation::kGmm,
       "gmm",
       "gmm",
       1,
       {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat},
       "planar Gaussians (Tan 2005), for the BRDF of that paper alone and worse near the rim"},
      {Representation::kMoments,
       "moments",
       "moments",
       1,
       {StorageEncoding::kHalf, StorageEncoding::kFloat},  // slopes reach 20, their products 400: no snorm
       "slope moments and the mean normal (LEAN, Toksvig, maketx --bumpslopes), cheap"},
      {Representation::kSh,
       "sh",
       "sh",
       1,
       {StorageEncoding::kHalf, StorageEncoding::kFloat},
       "spherical harmonics (Han 2007), for diffuse and broad highlights, nothing fitted"},
  };
  return all;
}

const RepresentationInfo& representation_info(Representation representation) {
  const auto& all = representations();
  const auto found = std::find_if(
      all.begin(), all.end(), [&](const RepresentationInfo& info) { return info.representation == representation; });
  MULTUM_CHECK(found != all.end());
  return *found;
}

void check_encoding(Representation representation, StorageEncoding encoding) {
  const RepresentationInfo& info = representation_info(representation);
  if (std::find(info.encodings.begin(), info.encodings.end(), encoding) != info.encodings.end()) return;
  std::string expected;
  for (const StorageEncoding one : info.encodings)
    expected += std::string(expected.empty() ? "" : " or ") + storage_encoding_name(one);
  throw Error(ErrorCode::kUsage, fmt::format("--data-format is {}, expected {} for --ndf {}: {}",
                                             storage_encoding_name(encoding), expected, info.option, info.help));
}

}  // namespace multum
