// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/lobes/movmf_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/header_hash.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_parts.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/asset/verify_scan.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {

struct MovmfScan::Lobes {
  std::size_t nonfinite = 0;
  WorstTexel sum_error, negative_amplitude, long_mean, missing_variance, weight_range;

  bool any_is_worse(const MovmfLevel& rows, std::size_t begin, std::size_t end, StorageEncoding encoding) const;
  bool any_is_worse(const MovmfFinest& rows, StorageEncoding encoding) const;
};

namespace {

// Returns the tolerance for sums of a and for lengths of r. It covers the rounding of the encoding
// (docs/reference/file_format.md).
float amplitude_tolerance(StorageEncoding encoding) { return encoding == StorageEncoding::kHalf ? 2e-3f : 2e-6f; }
// |a r| may exceed a by one outward step per component.
struct LengthExcess {
  float of_amplitude, constant;

  float of(float a) const { return a * of_amplitude + constant; }
};
LengthExcess length_excess(StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16) return {0.0f, 2.0f / 32767.0f};
  if (encoding == StorageEncoding::kHalf) return {2.0e-3f, 1e-7f};
  return {1e-6f, 1e-9f};
}

// The worst values so far. The two members of type float are exact, because they are computed from floats.
struct WorstLobe {
  double sum_error;
  float negative_amplitude, long_mean;
  LengthExcess excess;
};

// The number of texels that are checked together. Few blocks contain a new worst value, and the other blocks need no
// further check.
constexpr std::size_t kScanBlock = 256;

// Returns 1 if a lobe is worse than the worst lobe so far, or is not finite.
inline int is_worse_lobe(float x, float y, float z, float a, const WorstLobe& worst) {
  const float sum = std::abs(x) + std::abs(y) + std::abs(z) + std::abs(a);
  const float over = std::sqrt(x * x + y * y + z * z) - a - worst.excess.of(a);
  return static_cast<int>(!(sum < HUGE_VALF)) | static_cast<int>(-a > worst.negative_amplitude) |
         static_cast<int>(over > worst.long_mean);
}

// Checks `count` <= kScanBlock texels of one lobe, and adds their amplitudes to `sums`.
MULTUM_VECTOR_CLONES
int any_worse_lobe(const glm::vec4* lobes, std::size_t count, const WorstLobe& worst, double* sums) {
  const WorstLobe limits = worst;
  int found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    found |= is_worse_lobe(lobes[i].x, lobes[i].y, lobes[i].z, lobes[i].w, limits);
    sums[i] += static_cast<double>(lobes[i].w);
  }
  return found;
}

// Checks lobes of amplitude 1.
MULTUM_VECTOR_CLONES
int any_worse_normal(const glm::vec3* normals, std::size_t count, const WorstLobe& worst) {
  const WorstLobe limits = worst;
  int found = 0;
  for (std::size_t i = 0; i < count; ++i)
    found |= is_worse_lobe(normals[i].x, normals[i].y, normals[i].z, 1.0f, limits);
  return found;
}

MULTUM_VECTOR_CLONES
int any_worse_sum(const double* sums, std::size_t count, double worst) {
  int found = 0;
  for (std::size_t i = 0; i < count; ++i) found |= static_cast<int>(std::abs(sums[i] - 1.0) > worst);
  return found;
}

// Weights are from 0 to 1, so the weighted amplitudes of a lobe are from 0 to a. The tolerance covers the rounding of
// weights to 16-bit floats. It also covers the rounding of amplitudes to snorm16, which may differ from the fit by a
// step.
constexpr double kWeightTolerance = 2e-3;

// Returns how far the third value of a Gaussian is below the square of its mean. The tolerance allows rounding down.
double missing_variance(StorageEncoding encoding, const glm::vec4& v) {
  const glm::dvec4 lobe(v);
  if (!(lobe.w > 0.0)) return std::abs(lobe.z);
  const double square = (lobe.x * lobe.x + lobe.y * lobe.y) / lobe.w;
  const double step = encoding == StorageEncoding::kSnorm16 ? 1.01 / 32767.0
                      : encoding == StorageEncoding::kHalf  ? square * 1.05e-3 + 6e-8
                                                            : square * 1e-6 + 1e-9;
  return square - lobe.z - step;
}

// Scans and hashes every stored level. Returns the checksum.
std::string scan_file(MovmfReader& reader, int threads, const MovmfRowsSeen& seen, MovmfScan& scan) {
  const MovmfMipmap& header = reader.header();
  const std::vector<MovmfPart> parts = movmf_parts(header);
  BakedRowHash hash({parts.begin(), parts.end()});
  std::vector<float> values;
  for (int l = header.header.first_level; l < static_cast<int>(header.levels.size()); ++l) {
    const MovmfLevel& level = header.levels[static_cast<std::size_t>(l)];
    for (int row = 0; row < level.height; row += reader.tile_size()) {
      const int count = std::min(reader.tile_size(), level.height - row);
      MovmfLevel rows;
      if (l == 0) {
        const MovmfFinest finest = reader.read_finest(row, count);
        values.resize(finest.normals.size() * parts[0].channels.size());
        interleave(finest, 0, finest.normals.size(), values.data());
        hash.add(0, 0, values.data(), values.size());
        rows = expand(finest, header.lobe_count());
      } else {
        rows = reader.read_level(l, row, count);
        for_each_item(static_cast<int>(parts.size()), threads, [&](int i) {
          const auto p = static_cast<std::size_t>(i);
          if (parts[p].has_level(l))
            hash.add(p, l, parts[p].values(rows), texel_count(rows.width, rows.height) * parts[p].channels.size());
        });
      }
      scan.add(l, row, rows);
      if (seen) seen(l, row, rows);
    }
  }
  return hash.finish();
}

}  // namespace

MovmfScan::MovmfScan(const MovmfMipmap& header) : header_(header), lobes_(std::make_unique<Lobes>()) {}
MovmfScan::~MovmfScan() = default;

bool MovmfScan::Lobes::any_is_worse(const MovmfLevel& rows, std::size_t begin, std::size_t end,
                                    StorageEncoding encoding) const {
  const WorstLobe worst{sum_error.value, static_cast<float>(negative_amplitude.value),
                        static_cast<float>(long_mean.value), length_excess(encoding)};
  std::array<double, kScanBlock> sums{};
  int found = 0;
  for (const auto& lobe : rows.lobes) found |= any_worse_lobe(lobe.data() + begin, end - begin, worst, sums.data());
  return (found | any_worse_sum(sums.data(), end - begin, worst.sum_error)) != 0;
}

// At level 0, sums of amplitudes need no check, because each sum is 1.
bool MovmfScan::Lobes::any_is_worse(const MovmfFinest& rows, StorageEncoding encoding) const {
  const WorstLobe worst{sum_error.value, static_cast<float>(negative_amplitude.value),
                        static_cast<float>(long_mean.value), length_excess(encoding)};
  return any_worse_normal(rows.normals.data(), rows.normals.size(), worst) != 0;
}

// Returns whether the fast check suffices. Planar lobes and features are checked one by one.
bool MovmfScan::has_lobes_alone() const {
  return !lobe_family(header_.header.representation).is_planar && !header_.has_colours() &&
         header_.header.weight_count == 0;
}

void MovmfScan::add(int level, int first_row, const MovmfLevel& rows) {
  const std::size_t texels = texel_count(rows.width, rows.height);
  for (std::size_t begin = 0; begin < texels; begin += kScanBlock) {
    const std::size_t end = std::min(begin + kScanBlock, texels);
    if (!has_lobes_alone() || lobes_->any_is_worse(rows, begin, end, header_.header.encoding))
      add_texels(level, first_row, rows, begin, end);
  }
}

void MovmfScan::add_texels(int level, int first_row, const MovmfLevel& rows, std::size_t begin, std::size_t end) {
  Lobes& scan = *lobes_;
  const bool is_planar = lobe_family(header_.header.representation).is_planar;
  const StorageEncoding encoding = header_.header.encoding;
  const LengthExcess excess = length_excess(encoding);
  const auto width = static_cast<std::size_t>(rows.width);
  for (std::size_t i = begin; i < end; ++i) {
    const TexelPlace place{level, static_cast<int>(i % width), first_row + static_cast<int>(i / width)};
    double sum = 0.0;
    for (const auto& lobe : rows.lobes) {
      const glm::vec4& v = lobe[i];
      if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z) || !std::isfinite(v.w)) {
        ++scan.nonfinite;
        continue;
      }
      sum += static_cast<double>(v.w);
      scan.negative_amplitude.offer(-static_cast<double>(v.w), place);
      const float length = is_planar ? std::hypot(v.x, v.y) : glm::length(glm::vec3(v));
      scan.long_mean.offer(static_cast<double>(length - v.w - excess.of(v.w)), place);
      if (is_planar) scan.missing_variance.offer(missing_variance(encoding, v), place);
    }
    scan.sum_error.offer(std::abs(sum - 1.0), place);
    for (const auto& colour : rows.colours) {
      const glm::vec3& c = colour[i];
      if (!std::isfinite(c.x) || !std::isfinite(c.y) || !std::isfinite(c.z)) ++scan.nonfinite;
    }
    for (std::size_t j = 0; j < rows.weights.size(); ++j)
      scan_weights(rows.weights[j], i, header_.header.weight_count, static_cast<double>(rows.lobes[j][i].w),
                   kWeightTolerance, place, scan.weight_range, scan.nonfinite);
  }
}

// Every texel is in one lobe, so the zeros of the other lobes need no check.
void MovmfScan::add_finest(int first_row, const MovmfFinest& rows) {
  if (has_lobes_alone() && !lobes_->any_is_worse(rows, header_.header.encoding)) return;
  MovmfFinest whole = rows;
  std::fill(whole.lobe.begin(), whole.lobe.end(), std::uint8_t{0});
  add(0, first_row, expand(whole, 1));
}

std::vector<VerifyFinding> MovmfScan::findings() const {
  std::vector<VerifyFinding> findings;
  findings.push_back(finite_finding(lobes_->nonfinite, "non-finite values"));
  const double sum_limit = static_cast<double>(amplitude_tolerance(header_.header.encoding));
  findings.push_back({"sum of a", lobes_->sum_error.value <= sum_limit,
                      fmt::format("differs from 1 by at most {:.2e} ({}), expected at most {:.0e}",
                                  lobes_->sum_error.value, lobes_->sum_error.text(), sum_limit)});
  findings.push_back(
      {"a >= 0", lobes_->negative_amplitude.value <= 0.0,
       lobes_->negative_amplitude.value <= 0.0
           ? "no negative amplitude"
           : fmt::format("a = {} at {}", -lobes_->negative_amplitude.value, lobes_->negative_amplitude.text())});
  const bool is_planar = lobe_family(header_.header.representation).is_planar;
  findings.push_back(excess_finding(is_planar ? "|mean| <= 1" : "|r| <= 1", lobes_->long_mean,
                                    "no mean vector is longer than rounding allows",
                                    is_planar ? "|a mean| exceeds a by more than rounding allows,"
                                              : "|a r| exceeds a by more than rounding allows,"));
  if (is_planar)
    findings.push_back(excess_finding("variance", lobes_->missing_variance,
                                      "no variance is negative by more than rounding allows",
                                      "a variance is negative by more than rounding allows,"));
  if (header_.header.weight_count > 0)
    findings.push_back(weights_finding(header_.header.weight_count, lobes_->weight_range, "a"));
  return findings;
}

std::vector<VerifyFinding> verify_movmf(const std::string& path, int threads, const MovmfRowsSeen& seen) {
  MovmfReader reader(path, threads, TexelCheck::kReport);
  const MovmfMipmap& mipmap = reader.header();
  std::vector<VerifyFinding> findings;
  findings.push_back(
      {"structure", true,
       fmt::format("{} x {}, {}, {} {}{}, encoding {}", mipmap.width(), mipmap.height(), levels_text(mipmap),
                   mipmap.lobe_count(), lobe_family(mipmap.header.representation).plural,
                   materials_text(full_header(mipmap)), storage_encoding_name(mipmap.header.encoding))});
  MovmfScan scan(mipmap);
  const std::string hash = scan_file(reader, threads, seen, scan);
  findings.push_back(checksum_finding(hash, mipmap.header.provenance.content_hash, reader.changed_rows()));
  findings.push_back(header_finding(path));
  for (VerifyFinding& finding : scan.findings()) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace multum
