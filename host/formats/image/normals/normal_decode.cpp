// SPDX-License-Identifier: Apache-2.0
// Works in two steps, so that a repair never reads a repaired texel, and neither threads nor bands change the result.
// The first step decodes every texel and marks those without a direction. The second step fills the marked texels from
// unmarked neighbours.
#include "host/formats/image/normals/normal_decode.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

enum class TexelState : std::uint8_t { kGood, kUnused, kNonfinite, kZeroLength };

struct TexelCounts {
  std::int64_t unused = 0;
  std::int64_t nonfinite = 0;
  std::int64_t zero_length = 0;
  std::int64_t below_horizon = 0;
};

// Shorter vectors are zero within the precision of the file. With 8 bits, no code is 0, and mid-grey has length sqrt(3)
// / 255 = 0.0068. Half and float store 0 exactly.
double zero_length_of(SampleType type) {
  switch (type) {
    case SampleType::kUint8: return 0.007;
    case SampleType::kUint16: return 0.007 / 257.0;
    default: return 1e-6;
  }
}

// Values that are the same for all bands.
struct Decoding {
  const RawImage& image;
  VectorEncoding encoding;
  double zero_length;

  // Decodes the normal of one texel. The result is flat if the texel has no normal.
  TexelState decode(float r, float g, float b, glm::dvec3& n, TexelCounts& counts) const {
    n = glm::dvec3(0.0, 0.0, 1.0);
    if (encoding.empty_is_unused && is_empty(encoding, r, g, b)) {
      ++counts.unused;
      return TexelState::kUnused;
    }
    if (!is_vector_value(r) || !is_vector_value(g) || !is_vector_value(b)) {
      ++counts.nonfinite;
      return TexelState::kNonfinite;
    }
    if (is_unused(encoding, r, g, b)) {
      ++counts.unused;
      return TexelState::kUnused;
    }
    const glm::dvec3 v = decode_vector(encoding, r, g, b);
    if (std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z) < zero_length) {
      ++counts.zero_length;
      return TexelState::kZeroLength;
    }
    n = v;
    if (!normalise_above_horizon(n)) ++counts.below_horizon;
    return TexelState::kGood;
  }
};

// Rows [row_begin, row_end) of the map, texel by texel.
struct DecodedRows {
  int width;
  int row_begin;
  int row_end;
  std::array<std::vector<float>, 3> planes;
  std::vector<TexelState> states;

  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row - row_begin) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(column);
  }
  void set(std::size_t i, const glm::dvec3& n) {
    planes[0][i] = static_cast<float>(n.x);
    planes[1][i] = static_cast<float>(n.y);
    planes[2][i] = static_cast<float>(n.z);
  }
};

DecodedRows decode_rows(const Decoding& decoding, int row_begin, int row_end, TexelCounts& counts) {
  const int width = decoding.image.info().width;
  const auto channel_count = static_cast<std::size_t>(decoding.image.info().channel_count);
  RawRows raw;
  decoding.image.read_rows(row_begin, row_end - row_begin, raw);
  DecodedRows rows{width, row_begin, row_end, {}, {}};
  rows.states.resize(raw.values.size() / channel_count);
  for (std::vector<float>& plane : rows.planes) plane.resize(rows.states.size());
  for (std::size_t i = 0; i < rows.states.size(); ++i) {
    const float* texel = &raw.values[i * channel_count];
    glm::dvec3 n;
    rows.states[i] = decoding.decode(texel[0], texel[1], channel_count > 2 ? texel[2] : 0.0f, n, counts);
    rows.set(i, n);
  }
  return rows;
}

// Returns the mean of the good texels among the 8 neighbours inside the image. The result is flat if there are no good
// texels, or if they cancel out.
glm::dvec3 neighbours_mean(const DecodedRows& rows, int column, int row) {
  glm::dvec3 sum(0.0);
  for (int y = std::max(rows.row_begin, row - 1); y < std::min(rows.row_end, row + 2); ++y) {
    for (int x = std::max(0, column - 1); x < std::min(rows.width, column + 2); ++x) {
      const std::size_t i = rows.index(x, y);
      if (rows.states[i] == TexelState::kGood)
        sum += glm::dvec3(rows.planes[0][i], rows.planes[1][i], rows.planes[2][i]);
    }
  }
  if (sum.x * sum.x + sum.y * sum.y + sum.z * sum.z < 1e-12) return glm::dvec3(0.0, 0.0, 1.0);
  normalise_above_horizon(sum);
  return sum;
}

bool is_repaired(TexelState state, FixNan fix_nan) {
  return state == TexelState::kZeroLength || (state == TexelState::kNonfinite && fix_nan == FixNan::kBox3);
}

// Returns rows [row_begin, row_end) without holes. If there are holes, which is rare, decodes the rows again with the
// rows above and below.
DecodedRows repaired_rows(const Decoding& decoding, int row_begin, int row_end, FixNan fix_nan, TexelCounts& counts) {
  DecodedRows rows = decode_rows(decoding, row_begin, row_end, counts);
  const bool has_holes = std::any_of(rows.states.begin(), rows.states.end(),
                                     [fix_nan](TexelState state) { return is_repaired(state, fix_nan); });
  if (!has_holes) return rows;
  TexelCounts counted_by_others;
  const int halo_end = std::min(decoding.image.info().height, row_end + 1);
  rows = decode_rows(decoding, std::max(0, row_begin - 1), halo_end, counted_by_others);
  for (int row = row_begin; row < row_end; ++row)
    for (int column = 0; column < rows.width; ++column)
      if (const std::size_t i = rows.index(column, row); is_repaired(rows.states[i], fix_nan))
        rows.set(i, neighbours_mean(rows, column, row));
  return rows;
}

// Adds a warning to the report if more than kUnusedShareNoted of the texels were never written. Throws Error(kInput)
// for more than kUnusedShareMax, unless the settings declare the file a normal map. `empty` describes the contents of
// such texels.
void check_unused_share(const std::string& path, NormalMapRows& map, const NormalMapSettings& settings,
                        const char* empty) {
  const auto texel_count = static_cast<double>(map.normals.width()) * map.normals.height();
  const double share = static_cast<double>(map.report.unused_texels) / texel_count;
  if (share <= kUnusedShareNoted) return;
  const std::string found = fmt::format("{} of {:.0f} texels ({:.1f} %) are {}, which is not a valid normal",
                                        map.report.unused_texels, texel_count, 100.0 * share, empty);
  if (share > kUnusedShareMax && settings.bump_format != BumpFormat::kNormal)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: {}; expected at most {:.0f} %{}", path, found, 100.0 * kUnusedShareMax,
                            advice(" (if it is a normal map, use <bumpformat normal>)")));
  map.report.warnings.push_back(found + "; they count as unused and are read as flat");
}

}  // namespace

void check_repair_share(const std::string& path, const NormalMapRows& map, const NormalMapSettings& settings,
                        const std::string& hint) {
  const NormalMapReport& report = map.report;
  const std::int64_t repaired = report.nonfinite_repaired + report.zero_length_repaired + report.below_horizon_repaired;
  const auto texel_count = static_cast<double>(map.normals.width()) * map.normals.height();
  const double share = static_cast<double>(repaired) / texel_count;
  if (share <= static_cast<double>(settings.repair_share_max)) return;
  throw Error(
      ErrorCode::kInput,
      fmt::format(
          "{}: {} of {:.0f} texels ({:.2f} %) hold no usable normal: {} not finite, {} of zero length, {} below "
          "the horizon; expected at most {:.2f} %{}{}",
          path, repaired, texel_count, 100.0 * share, report.nonfinite_repaired, report.zero_length_repaired,
          report.below_horizon_repaired, 100.0 * static_cast<double>(settings.repair_share_max),
          advice(" (use <repair_max> to allow more repairs)"), hint));
}

NormalMapRows decode_normals(const std::string& path, const RawImage& image, const VectorEncoding& encoding,
                             const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                             Progress* progress) {
  const RawImageInfo& info = image.info();
  MULTUM_CHECK(info.channel_count == 2 || info.channel_count == 3);
  progress_stage(progress, "decode normals");
  const Decoding decoding{image, encoding, zero_length_of(info.sample_type)};
  NormalMapRows map{make_plane_store(info.width, info.height, spill), {}};
  const int band_rows = decoding_rows(info.width, spill);
  std::vector<TexelCounts> counts(static_cast<std::size_t>(row_band_count(info.height, band_rows)));
  for_each_row_band(info.height, band_rows, threads, progress, [&](int band, int row_begin, int row_end) {
    const DecodedRows rows =
        repaired_rows(decoding, row_begin, row_end, settings.fix_nan, counts[static_cast<std::size_t>(band)]);
    const std::size_t first = rows.index(0, row_begin);
    map.normals.write_rows(row_begin, row_end - row_begin,
                           {&rows.planes[0][first], &rows.planes[1][first], &rows.planes[2][first]});
  });
  for (const TexelCounts& band : counts) {
    map.report.unused_texels += band.unused;
    map.report.nonfinite_repaired += band.nonfinite;
    map.report.zero_length_repaired += band.zero_length;
    map.report.below_horizon_repaired += band.below_horizon;
  }
  check_unused_share(path, map, settings, encoding.empty_is_unused ? "black or NaN" : "black");
  check_repair_share(path, map, settings);
  return map;
}

}  // namespace multum
