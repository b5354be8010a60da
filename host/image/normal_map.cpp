// SPDX-License-Identifier: Apache-2.0
// Read, find out what the numbers mean, decode, repair: in this order, since a repair must not change the evidence.
#include "host/image/normal_map.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/image/encoding_detection.h"
#include "host/image/height_field.h"
#include "host/image/image_io.h"
#include "host/image/normal_decode.h"

namespace multum {
namespace {

void check_settings(const NormalMapSettings& settings) {
  if (!std::isfinite(settings.height_scale) || settings.height_scale == 0.0f)
    throw Error(ErrorCode::kUsage,
                fmt::format("--height-scale is {}, expected a finite number that is not 0", settings.height_scale));
  if (!(settings.repair_share_max >= 0.0f && settings.repair_share_max <= 1.0f))
    throw Error(ErrorCode::kUsage, fmt::format("--repair-max is {}, expected 0 to 1", settings.repair_share_max));
  if (settings.texel_count_max < 1)
    throw Error(ErrorCode::kUsage,
                fmt::format("texel_count_max: found {}, expected at least 1", settings.texel_count_max));
}

}  // namespace

NormalMap read_normal_map(const std::string& path, const NormalMapSettings& settings, int threads, Progress* progress) {
  check_settings(settings);
  progress_stage(progress, "read " + path);
  ImageReadSettings read_settings;
  read_settings.texel_count_max = settings.texel_count_max;
  read_settings.threads = threads;
  RawImage image = read_raw_image(path, read_settings, progress);
  const std::string format = image.format;
  progress_stage(progress, "find the encoding");
  const DetectedEncoding encoding = detect_encoding(path, image, settings, threads);
  NormalMap map;
  if (encoding.is_height_field) {
    map = normals_from_heights(path, std::move(image), settings, threads, progress);
  } else {
    check_finite(path, image, settings, threads);
    map = decode_normals(path, std::move(image), encoding.vectors, settings, threads, progress);
    map.report.encoding = encoding.description;
  }
  map.report.format = format;
  map.report.encoding_reason = encoding.reason;
  map.report.warnings.insert(map.report.warnings.begin(), encoding.warnings.begin(), encoding.warnings.end());
  return map;
}

}  // namespace multum
