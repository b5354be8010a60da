// SPDX-License-Identifier: Apache-2.0
#include "host/asset/movmf_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum {
namespace {

// How far sums of a and lengths of r may be from exact: what an encoding's rounding allows (docs/FORMAT.md).
float amplitude_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 2e-3f : 2e-6f; }
// |a r| exceeds a by at most one outward step a component.
float length_excess(StorageEncoding encoding, float a) {
  if (encoding == StorageEncoding::kSnorm16) return 2.0f / 32767.0f;
  if (encoding == StorageEncoding::kHalf) return a * 2.0e-3f + 1e-7f;
  return a * 1e-6f + 1e-9f;
}

struct Worst {
  double value = 0.0;
  int level = 0;
  std::size_t texel = 0;
  void offer(double candidate, int at_level, std::size_t at_texel) {
    if (candidate > value) *this = {candidate, at_level, at_texel};
  }
};

struct Scan {
  std::size_t nonfinite = 0;
  Worst sum_error, negative_amplitude, long_mean;
};

void scan_level(const MovmfMipmap& mipmap, int l, Scan& scan) {
  const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
  const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  for (std::size_t i = 0; i < texels; ++i) {
    double sum = 0.0;
    for (const auto& lobe : level.lobes) {
      const glm::vec4& v = lobe[i];
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z) || !std::isfinite(v.w)) {
        ++scan.nonfinite;
        continue;
      }
      sum += static_cast<double>(v.w);
      scan.negative_amplitude.offer(-static_cast<double>(v.w), l, i);
      scan.long_mean.offer(static_cast<double>(glm::length(glm::vec3(v)) - v.w - length_excess(mipmap.encoding, v.w)),
                           l, i);
    }
    scan.sum_error.offer(std::abs(sum - 1.0), l, i);
    for (const auto& colour : level.colours) {
      const glm::vec3& c = colour[i];
      if (!std::isfinite(c.x) || !std::isfinite(c.y) || !std::isfinite(c.z)) ++scan.nonfinite;
    }
  }
}

std::string at(const MovmfMipmap& mipmap, const Worst& worst) {
  const auto width = static_cast<std::size_t>(mipmap.levels[static_cast<std::size_t>(worst.level)].width);
  return fmt::format("level {}, texel ({}, {})", worst.level, worst.texel % width, worst.texel / width);
}

}  // namespace

std::vector<VerifyFinding> verify_movmf(const std::string& path, int threads) {
  const MovmfMipmap mipmap = read_movmf_mipmap(path);
  std::vector<VerifyFinding> findings;
  findings.push_back({"structure", true,
                      fmt::format("{} x {}, {}, {} lobes{}, encoding {}", mipmap.width(), mipmap.height(),
                                  levels_text(mipmap), mipmap.lobe_count(), mipmap.has_colours() ? " with colours" : "",
                                  storage_encoding_name(mipmap.encoding))});
  const std::string hash = movmf_content_hash(mipmap, threads);
  findings.push_back({"checksum", hash == mipmap.provenance.content_hash,
                      hash == mipmap.provenance.content_hash
                          ? hash
                          : "found " + hash + ", expected " + mipmap.provenance.content_hash + " as the header says"});
  Scan scan;
  for (int l = mipmap.first_level; l < static_cast<int>(mipmap.levels.size()); ++l) scan_level(mipmap, l, scan);
  findings.push_back({"finite", scan.nonfinite == 0, fmt::format("{} non-finite values, expected 0", scan.nonfinite)});
  const double sum_limit = static_cast<double>(amplitude_tolerance(mipmap.encoding));
  findings.push_back({"sum of a", scan.sum_error.value <= sum_limit,
                      fmt::format("differs from 1 by at most {:.2e} ({}), expected at most {:.0e}",
                                  scan.sum_error.value, at(mipmap, scan.sum_error), sum_limit)});
  findings.push_back({"a >= 0", scan.negative_amplitude.value <= 0.0,
                      scan.negative_amplitude.value <= 0.0 ? "no negative amplitude"
                                                           : fmt::format("a = {} at {}", -scan.negative_amplitude.value,
                                                                         at(mipmap, scan.negative_amplitude))});
  findings.push_back({"|r| <= 1", scan.long_mean.value <= 0.0,
                      scan.long_mean.value <= 0.0
                          ? "no mean vector is longer than rounding allows"
                          : fmt::format("|a r| exceeds a by {:.2e} more than rounding allows at {}",
                                        scan.long_mean.value, at(mipmap, scan.long_mean))});
  return findings;
}

}  // namespace multum
