// SPDX-License-Identifier: Apache-2.0
// Two passes, so that a repair never reads a repaired texel and no order of threads can be seen: the first decodes
// every texel and marks those that hold no direction; the second fills the marked ones from unmarked neighbours.
#include "host/image/normal_decode.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/parallel.h"

namespace multum {
namespace {

enum class TexelState : std::uint8_t { kGood, kUnused, kNonfinite, kZeroLength };

struct TexelCounts {
  std::int64_t unused = 0;
  std::int64_t nonfinite = 0;
  std::int64_t zero_length = 0;
  std::int64_t below_horizon = 0;
};

// Shorter than this is zero as far as the file can tell: for 8 bits mid-grey, where no code is 0, has length
// sqrt(3) / 255 = 0.0068; half and float hold 0 itself.
double zero_length_of(SampleType type) {
  switch (type) {
    case SampleType::kUint8: return 0.007;
    case SampleType::kUint16: return 0.007 / 257.0;
    default: return 1e-6;
  }
}

struct DecodePass {
  const VectorEncoding& encoding;
  double zero_length;
  int width;
  RawImage& image;
  std::vector<TexelState>& states;

  // Decodes one texel in place. A third plane is there always: two-channel files get one of zeros.
  void decode(std::size_t i, TexelCounts& counts) const {
    float& r = image.planes[0][i];
    float& g = image.planes[1][i];
    float& b = image.planes[2][i];
    glm::dvec3 n(0.0, 0.0, 1.0);
    if (!std::isfinite(r) || !std::isfinite(g) || !std::isfinite(b)) {
      states[i] = TexelState::kNonfinite;
      ++counts.nonfinite;
    } else if (is_unused(encoding, r, g, b)) {
      states[i] = TexelState::kUnused;
      ++counts.unused;
    } else {
      n = decode_vector(encoding, r, g, b);
      if (std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z) < zero_length) {
        states[i] = TexelState::kZeroLength;
        ++counts.zero_length;
        n = glm::dvec3(0.0, 0.0, 1.0);
      } else if (!normalise_above_horizon(n)) {
        ++counts.below_horizon;
      }
    }
    r = static_cast<float>(n.x);
    g = static_cast<float>(n.y);
    b = static_cast<float>(n.z);
  }
};

// Mean of the good texels among the 8 neighbours inside the image; flat when there is none or they cancel.
glm::dvec3 neighbours_mean(const NormalMap& map, const std::vector<TexelState>& states, int column, int row) {
  glm::dvec3 sum(0.0);
  for (int y = std::max(0, row - 1); y <= std::min(map.height - 1, row + 1); ++y) {
    for (int x = std::max(0, column - 1); x <= std::min(map.width - 1, column + 1); ++x) {
      const std::size_t i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      if (states[i] == TexelState::kGood) sum += glm::dvec3(map.x[i], map.y[i], map.z[i]);
    }
  }
  if (sum.x * sum.x + sum.y * sum.y + sum.z * sum.z < 1e-12) return glm::dvec3(0.0, 0.0, 1.0);
  normalise_above_horizon(sum);
  return sum;
}

void repair_texels(NormalMap& map, const std::vector<TexelState>& states, FixNan fix_nan, int threads) {
  for_each_row_band(map.height, kRowsPerBand, threads, [&](int, int row_begin, int row_end) {
    for (int row = row_begin; row < row_end; ++row) {
      for (int column = 0; column < map.width; ++column) {
        const std::size_t i =
            static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(column);
        const bool from_neighbours =
            states[i] == TexelState::kZeroLength || (states[i] == TexelState::kNonfinite && fix_nan == FixNan::kBox3);
        if (!from_neighbours) continue;
        const glm::dvec3 n = neighbours_mean(map, states, column, row);
        map.x[i] = static_cast<float>(n.x);
        map.y[i] = static_cast<float>(n.y);
        map.z[i] = static_cast<float>(n.z);
      }
    }
  });
}

}  // namespace

std::int64_t check_finite(const std::string& path, const RawImage& image, const NormalMapSettings& settings,
                          int threads) {
  const int band_count = row_band_count(image.height, kRowsPerBand);
  std::vector<std::int64_t> first(static_cast<std::size_t>(band_count), -1);
  std::vector<std::int64_t> count(static_cast<std::size_t>(band_count), 0);
  for_each_row_band(image.height, kRowsPerBand, threads, [&](int band, int row_begin, int row_end) {
    const auto slot = static_cast<std::size_t>(band);
    for (std::int64_t i = std::int64_t{row_begin} * image.width; i < std::int64_t{row_end} * image.width; ++i) {
      const bool is_finite = std::all_of(
          image.planes.begin(), image.planes.end(),
          [i](const std::vector<float>& plane) { return std::isfinite(plane[static_cast<std::size_t>(i)]); });
      if (is_finite) continue;
      ++count[slot];
      if (first[slot] < 0) first[slot] = i;
    }
  });
  std::int64_t total = 0;
  for (const std::int64_t value : count) total += value;
  if (total > 0 && (settings.check_nan || settings.fix_nan == FixNan::kNone)) {
    const std::int64_t i = *std::find_if(first.begin(), first.end(), [](std::int64_t value) { return value >= 0; });
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: found NaN or Inf at column {}, row {} (the first of {} texels), expected finite values", path,
                    i % image.width, i / image.width, total));
  }
  return total;
}

void check_repair_share(const std::string& path, const NormalMap& map, const NormalMapSettings& settings) {
  const NormalMapReport& report = map.report;
  const std::int64_t repaired = report.nonfinite_repaired + report.zero_length_repaired + report.below_horizon_repaired;
  const auto texel_count = static_cast<double>(map.width) * map.height;
  const double share = static_cast<double>(repaired) / texel_count;
  if (share <= static_cast<double>(settings.repair_share_max)) return;
  throw Error(
      ErrorCode::kInput,
      fmt::format(
          "{}: {} of {:.0f} texels ({:.2f} %) hold no usable normal: {} not finite, {} of zero length, {} below "
          "the horizon; expected at most {:.2f} % (raise --repair-max to repair them all the same)",
          path, repaired, texel_count, 100.0 * share, report.nonfinite_repaired, report.zero_length_repaired,
          report.below_horizon_repaired, 100.0 * static_cast<double>(settings.repair_share_max)));
}

void check_unused_share(const std::string& path, NormalMap& map, const NormalMapSettings& settings) {
  const auto texel_count = static_cast<double>(map.width) * map.height;
  const double share = static_cast<double>(map.report.unused_texels) / texel_count;
  if (share <= kUnusedShareNoted) return;
  const std::string found = fmt::format("{} of {:.0f} texels ({:.1f} %) are black, which is no normal",
                                        map.report.unused_texels, texel_count, 100.0 * share);
  if (share > kUnusedShareMax && settings.bump_format != BumpFormat::kNormal)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: {}; expected at most {:.0f} % (if it is a normal map all the same, say so: "
                            "--bumpformat normal)",
                            path, found, 100.0 * kUnusedShareMax));
  map.report.warnings.push_back(found + "; they are taken as never written, and as flat");
}

NormalMap decode_normals(const std::string& path, RawImage image, const VectorEncoding& encoding,
                         const NormalMapSettings& settings, int threads, Progress* progress) {
  MULTUM_CHECK(image.planes.size() == 2 || image.planes.size() == 3);
  progress_stage(progress, "decode normals");
  image.planes.resize(3, std::vector<float>(image.planes[0].size(), 0.0f));
  std::vector<TexelState> states(image.planes[0].size(), TexelState::kGood);
  const DecodePass pass{encoding, zero_length_of(image.sample_type), image.width, image, states};
  std::vector<TexelCounts> counts(static_cast<std::size_t>(row_band_count(image.height, kRowsPerBand)));
  for_each_row_band(image.height, kRowsPerBand, threads, [&](int band, int row_begin, int row_end) {
    const auto width = static_cast<std::size_t>(image.width);
    TexelCounts& band_counts = counts[static_cast<std::size_t>(band)];
    for (std::size_t i = static_cast<std::size_t>(row_begin) * width; i < static_cast<std::size_t>(row_end) * width;
         ++i)
      pass.decode(i, band_counts);
  });
  NormalMap map;
  map.width = image.width;
  map.height = image.height;
  map.x = std::move(image.planes[0]);
  map.y = std::move(image.planes[1]);
  map.z = std::move(image.planes[2]);
  for (const TexelCounts& band : counts) {
    map.report.unused_texels += band.unused;
    map.report.nonfinite_repaired += band.nonfinite;
    map.report.zero_length_repaired += band.zero_length;
    map.report.below_horizon_repaired += band.below_horizon;
  }
  check_unused_share(path, map, settings);
  check_repair_share(path, map, settings);
  repair_texels(map, states, settings.fix_nan, threads);
  return map;
}

}  // namespace multum
