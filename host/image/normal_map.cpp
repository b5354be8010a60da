// SPDX-License-Identifier: Apache-2.0
// Read, find out what the numbers mean, decode, repair: in this order, since a repair must not change the evidence.
#include "host/image/normal_map.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/image/encoding_detection.h"
#include "host/image/height_field.h"
#include "host/image/image_reader.h"
#include "host/image/image_survey.h"
#include "host/image/normal_decode.h"

namespace multum {
namespace {

void check_settings(const NormalMapSettings& settings) {
  if (!std::isfinite(settings.height_scale) || settings.height_scale == 0.0f)
    throw Error(ErrorCode::kUsage,
                fmt::format("--height-scale is {}, expected a finite number that is not 0", settings.height_scale));
  if (!std::isfinite(settings.normal_scale))
    throw Error(ErrorCode::kUsage,
                fmt::format("--normal-scale is {}, expected a finite number", settings.normal_scale));
  if (!(settings.repair_share_max >= 0.0f && settings.repair_share_max <= 1.0f))
    throw Error(ErrorCode::kUsage, fmt::format("--repair-max is {}, expected 0 to 1", settings.repair_share_max));
  if (settings.texel_count_max < 1)
    throw Error(ErrorCode::kUsage,
                fmt::format("texel_count_max: found {}, expected at least 1", settings.texel_count_max));
}

void check_finite(const std::string& path, const ImageSurvey& survey, int width, const NormalMapSettings& settings) {
  if (survey.nonfinite_count() == 0 || (!settings.check_nan && settings.fix_nan != FixNan::kNone)) return;
  const std::int64_t first = survey.first_nonfinite();
  throw Error(ErrorCode::kInput,
              fmt::format("{}: found NaN or Inf at column {}, row {} (the first of {} texels), expected finite values",
                          path, first % width, first / width, survey.nonfinite_count()));
}

}  // namespace

NormalMapRows read_normal_map_rows(const std::string& path, const NormalMapSettings& settings,
                                   const ReadingPlace& place, int threads, Progress* progress) {
  check_settings(settings);
  progress_stage(progress, "read " + path);
  ImageReader reader(path, {settings.texel_count_max, threads, place.band_rows});
  const RawImageInfo info = reader.info();
  RawImage image(info, place);
  ImageSurvey survey(info, likely_encodings(info, settings));
  const auto keep = [&](const RawBand& band) {
    image.write(band);
    survey.add(band);
  };
  reader.read(keep, progress);
  progress_stage(progress, "find the encoding");
  const DetectedEncoding encoding = detect_encoding(path, image, survey, settings, threads);
  check_finite(path, survey, info.width, settings);
  NormalMapRows map =
      encoding.is_height_field
          ? normals_from_heights(path, image, survey.nonfinite_count(), settings, place, threads, progress)
          : decode_normals(path, image, encoding.vectors, settings, place, threads, progress);
  if (!encoding.is_height_field) map.report.encoding = encoding.description;
  map.report.format = info.format;
  map.report.encoding_reason = encoding.reason;
  map.report.warnings.insert(map.report.warnings.begin(), encoding.warnings.begin(), encoding.warnings.end());
  map.report.warnings.insert(map.report.warnings.begin(), info.notes.begin(), info.notes.end());
  return map;
}

NormalMap read_normal_map(const std::string& path, const NormalMapSettings& settings, int threads, Progress* progress) {
  NormalMapRows rows = read_normal_map_rows(path, settings, {}, threads, progress);
  NormalMap map;
  map.width = rows.normals.width();
  map.height = rows.normals.height();
  map.report = std::move(rows.report);
  std::array<std::vector<float>, 3> planes = rows.normals.take_planes();
  map.x = std::move(planes[0]);
  map.y = std::move(planes[1]);
  map.z = std::move(planes[2]);
  return map;
}

}  // namespace multum
