// SPDX-License-Identifier: Apache-2.0
// Tests how the rounding of the file encodings affects the spread of a lobe
// (host/formats/asset/lobes/movmf_quantize.cpp; docs/reference/file_format.md, "Rounding"). No kernel runs here.
// Rounding is the last step in which the results of a kernel can lose accuracy.
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/split_mix.h"
#include "host/lab/reference/movmf_rounding.h"
#include "host/lab/reference/shading.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"

namespace multum {
namespace {

using Texels = std::vector<std::vector<glm::vec4>>;  // [texel][lobe] (a r, a)
using Rounding = std::function<Texels(const Texels&)>;

Texels as_stored(const Texels& texels, StorageEncoding encoding) {
  MovmfLevel level;
  level.width = static_cast<int>(texels.size());
  level.height = 1;
  level.lobes.resize(texels.front().size());
  for (const auto& lobes : texels)
    for (std::size_t j = 0; j < lobes.size(); ++j) level.lobes[j].push_back(lobes[j]);
  quantize_movmf(level, encoding, 1);
  Texels result = texels;
  for (std::size_t i = 0; i < texels.size(); ++i)
    for (std::size_t j = 0; j < result[i].size(); ++j) result[i][j] = level.lobes[j][i];
  return result;
}

// Rounds each channel to its nearest value.
Texels by_channel(const Texels& texels, StorageEncoding encoding) {
  Texels result = texels;
  for (auto& lobes : result)
    for (glm::vec4& lobe : lobes)
      for (int k = 0; k < 4; ++k)
        lobe[k] = encoding == StorageEncoding::kHalf ? static_cast<float>(half(lobe[k]))
                                                     : std::round(lobe[k] * 32767.0f) / 32767.0f;
  return result;
}

Rounding rounding(StorageEncoding encoding, bool naive) {
  return [=](const Texels& texels) { return naive ? by_channel(texels, encoding) : as_stored(texels, encoding); };
}

// Tests the stored spread, 1 - |r|, of four lobes that contain one direction each.
void single_directions(const Rounding& rounded, WorstError& worst) {
  SplitMix64 random(32767);
  Texels texels;
  for (int i = 0; i < 4000; ++i) {
    double shares[4], total = 0.0;
    for (double& share : shares) total += share = std::pow(10.0, -3.0 * random.uniform());
    texels.emplace_back();
    for (const double share : shares) {
      const glm::dvec3 n = tilted(90.0 * random.uniform(), 6.28 * random.uniform());
      texels.back().push_back(glm::vec4(glm::dvec4(n, 1.0) * (share / total)));
    }
  }
  const Texels stored = rounded(texels);
  for (std::size_t i = 0; i < stored.size(); ++i)
    for (const glm::vec4& lobe : stored[i]) {
      const auto amplitude = static_cast<double>(lobe.w);
      worst.add(amplitude > 0.0 ? std::max(0.0, 1.0 - glm::length(glm::dvec3(lobe)) / amplitude) : 0.0,
                fmt::format("texel {}, amplitude {:.3g}", i, amplitude));
    }
}

// Tests one lobe of amplitude 1 with increasing sharpness, up to the limit of the encoding.
void sharpest_spreads(const Rounding& rounded, StorageEncoding encoding, WorstError& worst) {
  for (const double share : {0.1, 0.5, 1.0}) {
    const double kappa = share * static_cast<double>(storage_kappa_max(encoding));
    const double spread = reference::vmf_spread(kappa);
    double sum = 0.0;
    Texels texels;
    for (int i = 0; i < 500; ++i) {
      const glm::dvec3 n = tilted(0.18 * i, 0.1 * i);
      texels.push_back({glm::vec4(glm::dvec4(n * (1.0 - spread), 1.0))});
    }
    for (const auto& lobes : rounded(texels))
      sum += std::abs(static_cast<double>(lobes[0].w) - glm::length(glm::dvec3(lobes[0])) - spread) / spread;
    worst.add(sum / 500.0, fmt::format("kappa {:.3g}", kappa));
  }
}

// Compares stored texels with the rounding that docs/reference/file_format.md describes.
void as_the_format_says(StorageEncoding encoding, const Rounding& rounded, WorstError& worst) {
  SplitMix64 random(7);
  Texels texels;
  for (int i = 0; i < 3000; ++i) {
    const double share = random.uniform();
    const glm::dvec3 a = tilted(90.0 * random.uniform(), 6.28 * random.uniform()),
                     b = tilted(90.0 * random.uniform(), 1.0);
    texels.push_back({glm::vec4(glm::dvec4(a * (1.0 - std::pow(10.0, -7.0 * random.uniform())), 1.0) * share),
                      glm::vec4(glm::dvec4(b, 1.0) * (1.0 - share))});
  }
  const Texels stored = rounded(texels);
  for (std::size_t i = 0; i < stored.size(); ++i)
    worst.add(stored[i] == reference::round_texel(texels[i], encoding) ? 0.0 : 1.0, fmt::format("texel {}", i));
}

std::vector<NumericalCase> cases_of(StorageEncoding encoding, const std::string& name) {
  const Rounding stored = rounding(encoding, false), naive = rounding(encoding, true);
  const std::string
      formula = "movmf_quantize",
      lost =
          "if each channel is rounded separately, |r| of a lobe with amplitude a changes by up to 1/a rounding steps";
  return {
      {{name + "-single-directions", formula, lost + ", which blurs a highlight",
        "the encoder rounds the four values of a lobe together, and never shortens the r of a single direction", 1e-7,
        "absolute error of 1 - |r|", "the spread of a single direction must be 0, except for float rounding"},
       [=](Device&, WorstError& worst) { single_directions(stored, worst); },
       {},
       [=](WorstError& worst) { single_directions(naive, worst); }},
      {{name + "-sharpest-spreads", formula, lost + ", which is more than the spread",
        "the encoder chooses the rounding whose projection on the lobe's direction is closest to a |r|, and reports "
        "lobes above the encoding's kappa limit",
        0.09, "mean relative error of 1 - |r| over directions",
        "at the encoding's kappa limit, rounding changes a spread by at most a quarter (storage_kappa_max)"},
       [=](Device&, WorstError& worst) { sharpest_spreads(stored, encoding, worst); },
       {},
       [=](WorstError& worst) { sharpest_spreads(naive, encoding, worst); }},
      {{name + "-as-the-format-says", formula,
        "the stored texel violates the rounding rule in docs/reference/file_format.md",
        "the encoder tries every possible rounding, as the rule requires", kNothingWrong, "wrong texels",
        "no bit may differ"},
       [=](Device&, WorstError& worst) { as_the_format_says(encoding, stored, worst); },
       {},
       [=](WorstError& worst) { as_the_format_says(encoding, naive, worst); }},
  };
}

}  // namespace

std::vector<NumericalCase> storage_cases() {
  std::vector<NumericalCase> cases = cases_of(StorageEncoding::kHalf, "half");
  for (NumericalCase& c : cases_of(StorageEncoding::kSnorm16, "snorm16")) cases.push_back(std::move(c));
  return cases;
}

}  // namespace multum
