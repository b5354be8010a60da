// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/baked_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/bakes/bake/bake_source.h"
#include "host/bakes/bake/ndf_bake.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The allowed differences. The measurement may run on another device than the bake, and both devices shade in single
// precision. Six maps of 16 to 64 texels per side were baked with PoCL 3.1 and measured with Oclgrind 21.10. No error
// differs by more than 5e-7, which is half a unit of the sixth decimal place, the last one in the header. GPUs were not
// measured. The limit of 1 % leaves room for the errors of exp and sqrt on GPUs. If an error is nearly 0, as at the
// finest level of a smooth map, rounding is a large part of it. For this case there is a second limit, which is one
// unit of the last digit that `multum info` prints.
constexpr double kAllowedRelative = 0.01;
constexpr double kAllowedAbsolute = 1e-4;
// Errors without an interval come from earlier program versions, which measured other texels and gave too much weight
// to texels at the borders of thin maps. For example, for level 1 of a map of 4097 x 7 texels they stated 42.6 %
// instead of 60.9 %, which is too low by a factor of 1.43. The limit of 0.5 detects damage, not rounding.
constexpr double kAllowedOfUnstated = 0.5;

// Compares the properties in a file's header with the source. Returns a difference, which means that the file was baked
// from another source, or an empty string.
std::string other_shape(const BakedHeader& header, const BakeSource& source) {
  const PlaneStore& normals = source.map.normals;
  if (header.width != normals.width() || header.height != normals.height())
    return fmt::format("holds {} x {} texels, but its source has {} x {}", header.width, header.height, normals.width(),
                       normals.height());
  const int weight_count = source.weights ? source.weights->count : 0;
  if (header.weight_count != weight_count)
    return fmt::format("has {} weights, but its source has {}", header.weight_count, weight_count);
  if (header.has_roughness != source.has_roughness())
    return header.has_roughness ? "has roughness, but its source has no roughness map"
                                : "has no roughness, but its source has a roughness map";
  if (header.has_colours != source.albedo.has_value())
    return header.has_colours ? "has colours, but its source has no albedo"
                              : "has no colours, but its source has an albedo";
  return "";
}

// Verifies the file and passes every row to a meter. Returns the damage in words, or an empty string. Progress: one
// unit per row.
std::string find_damage(const BakeJob& job, Representation representation, VerifiedFile& file, Progress* progress) {
  AccuracySettings settings;
  settings.threads = job.threads;
  settings.first_level = first_measured_level(job);
  try {
    file = ndf_bake(representation).verify(job, settings, progress);
    for (const VerifyFinding& finding : file.findings)
      if (!finding.passed) return fmt::format("{}: {}", finding.check, finding.detail);
  } catch (const Error& error) {
    // At this point the source has been read, so the unreadable file is the baked one. The check reports this as a
    // finding, not as an error.
    if (error.code() != ErrorCode::kInput) throw;
    return error.what();
  }
  return "";
}

std::uint64_t stored_rows(const BakedHeader& header) {
  std::uint64_t rows = 0;
  for (int l = header.first_level; l < header.level_count(); ++l)
    rows += static_cast<std::uint64_t>(mip_level_size(header.height, l));
  return rows;
}

// NaN counts as worse than any number.
double comparable(double error) { return std::isnan(error) ? std::numeric_limits<double>::infinity() : error; }

std::string row_name(const AccuracyRow& row) {
  return fmt::format("level {}, {}, {}", row.level, accuracy_point_name(row.point), row.brdf.text());
}

}  // namespace

BakedCheck check_baked_file(const BakeJob& job, Device& device, Progress* progress) {
  const BakeSource source = read_bake_source(job, MapReadings::kFew, progress);
  const BakedHeader header = read_baked_header(job.output);
  BakedCheck check;
  check.damage = other_shape(header, source);
  if (!check.damage.empty()) return check;
  progress_start(progress, stored_rows(header) + 1);
  progress_stage(progress, "verify");
  VerifiedFile file;
  check.damage = find_damage(job, header.representation, file, progress);
  if (check.damage.empty()) {
    progress_stage(progress, "measure");
    check.measured.rows = file.meter->run(device, source.map.normals, source.colours(), progress);
    check.measured.footprint_errors = file.meter->footprint_errors();
  }
  progress_finish(progress);
  return check;
}

std::optional<double> worst_error(const std::vector<FootprintError>& errors) {
  std::optional<double> worst;
  for (const FootprintError& one : errors) worst = std::max(worst.value_or(0.0), comparable(one.error));
  return worst;
}

std::string worse_than_stated(const StatedErrors& measured, const StatedErrors& stated) {
  std::string worst;
  double worst_excess = 0.0;
  for (const FootprintError& one : measured.footprint_errors) {
    if (stated.footprint_errors.empty()) break;
    const auto same = std::find_if(stated.footprint_errors.begin(), stated.footprint_errors.end(),
                                   [&](const FootprintError& other) { return other.brdf == one.brdf; });
    if (same == stated.footprint_errors.end())
      return fmt::format("does not state its pixel error for {}", one.brdf.text());
    const double excess = comparable(one.error) - (same->error * (1.0 + kAllowedRelative) + kAllowedAbsolute);
    if (excess <= worst_excess) continue;
    worst_excess = excess;
    worst = fmt::format("has a pixel error of {:.4g} % for {}, but its header states {:.4g} %", 100.0 * one.error,
                        one.brdf.text(), 100.0 * same->error);
  }
  if (!worst.empty()) return worst;
  for (const AccuracyRow& row : measured.rows) {
    const auto same = std::find_if(stated.rows.begin(), stated.rows.end(), [&](const AccuracyRow& other) {
      return other.level == row.level && other.point == row.point && other.brdf == row.brdf;
    });
    if (same == stated.rows.end()) return fmt::format("does not state its error for {}", row_name(row));
    const double allowed = same->confidence == kIntervalUnstated ? kAllowedOfUnstated : kAllowedRelative;
    const double excess = comparable(row.error) - (same->error * (1.0 + allowed) + kAllowedAbsolute);
    if (excess <= worst_excess) continue;
    worst_excess = excess;
    worst = fmt::format("has an error of {:.4g} % at {}, but its header states {:.4g} %", 100.0 * row.error,
                        row_name(row), 100.0 * same->error);
  }
  return worst;
}

}  // namespace multum
