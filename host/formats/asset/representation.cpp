// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/representation.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/averages/moment_verify.h"
#include "host/formats/asset/averages/sh_verify.h"
#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_verify.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

int lobe_textures(const TexelCounts& counts) { return counts.lobes; }
int mean_normal(const TexelCounts&) { return 3; }
BakedHeader read_lobe_header(const std::string& path) { return full_header(read_movmf_header(path)); }
std::vector<VerifyFinding> verify_lobes(const std::string& path, int threads) { return verify_movmf(path, threads); }
std::uint64_t lobe_gpu_bytes(const std::string& path) { return movmf_gpu_bytes(read_movmf_header(path)); }

}  // namespace

const char* storage_encoding_name(StorageEncoding encoding) { return choice_name(kStorageEncodings, encoding); }

const std::vector<RepresentationInfo>& representations() {
  static const std::vector<StorageEncoding> every = {StorageEncoding::kSnorm16, StorageEncoding::kHalf,
                                                     StorageEncoding::kFloat};
  // snorm16 cannot store these values. Slopes reach 20, their products reach 400, and coefficients exceed 1.
  static const std::vector<StorageEncoding> wide = {StorageEncoding::kHalf, StorageEncoding::kFloat};
  static const std::vector<RepresentationInfo> all = {
      {.representation = Representation::kMovmf,
       .option = choice_name(kRepresentations, Representation::kMovmf),
       .name = "movmf",
       .version = 3,
       .encodings = every,
       .help = "lobes (Han 2007), the most accurate",
       .contents = "lobes",
       .lobes = &kSphericalLobes,
       .has_kappa = true,
       .has_order = false,
       .has_slopes = false,
       .takes_every_brdf = true,
       .value_textures = lobe_textures,
       .mean_count = mean_normal,
       .read_header = read_lobe_header,
       .verify = verify_lobes,
       .gpu_bytes = lobe_gpu_bytes},
      {.representation = Representation::kGmm,
       .option = choice_name(kRepresentations, Representation::kGmm),
       .name = "gmm",
       .version = 1,
       .encodings = every,
       .help = "planar Gaussians (Tan 2005), only for the BRDF of that paper; less accurate for steep normals",
       .contents = "planar Gaussians",
       .lobes = &kPlanarLobes,
       .has_kappa = false,
       .has_order = false,
       .has_slopes = false,
       .takes_every_brdf = false,
       .value_textures = lobe_textures,
       .mean_count = mean_normal,
       .read_header = read_lobe_header,
       .verify = verify_lobes,
       .gpu_bytes = lobe_gpu_bytes},
      {.representation = Representation::kMoments,
       .option = choice_name(kRepresentations, Representation::kMoments),
       .name = "moments",
       .version = 1,
       .encodings = wide,
       .help = "slope moments and the mean normal (LEAN, Toksvig, maketx --bumpslopes), which are cheap",
       .contents = "moments of slopes (LEAN)",
       .lobes = nullptr,
       .has_kappa = false,
       .has_order = false,
       .has_slopes = true,
       .takes_every_brdf = true,
       .value_textures = [](const TexelCounts&) { return 2; },
       .mean_count = [](const TexelCounts&) { return 8; },  // the mean normal and five moments
       .read_header = read_moment_header,
       .verify = [](const std::string& path, int threads) { return verify_moments(path, threads); },
       .gpu_bytes = [](const std::string& path) { return moment_gpu_bytes(read_moment_header(path)); }},
      {.representation = Representation::kSh,
       .option = choice_name(kRepresentations, Representation::kSh),
       .name = "sh",
       .version = 1,
       .encodings = wide,
       .help = "spherical harmonics (Han 2007), for diffuse light and broad highlights; they need no fitting",
       .contents = "spherical harmonics",
       .lobes = nullptr,
       .has_kappa = false,
       .has_order = true,
       .has_slopes = false,
       .takes_every_brdf = true,
       .value_textures = [](const TexelCounts& counts) { return sh_part_count(counts.sh_order); },
       .mean_count = [](const TexelCounts& counts) { return sh_coefficient_count(counts.sh_order); },
       .read_header = [](const std::string& path) { return read_sh_header(path).header; },
       .verify = [](const std::string& path, int threads) { return verify_sh(path, threads); },
       .gpu_bytes = [](const std::string& path) { return sh_gpu_bytes(read_sh_header(path)); }},
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

bool holds_lobes(Representation representation) { return representation_info(representation).lobes != nullptr; }

int texture_count(Representation representation, const TexelCounts& counts, int features) {
  const RepresentationInfo& info = representation_info(representation);
  return info.value_textures(counts) + features * (info.lobes != nullptr ? counts.lobes : 1);
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
