// SPDX-License-Identifier: Apache-2.0
// Read, find out what the numbers mean, decode, repair: in this order, since a repair must not change the evidence.
#include "host/image/normals/normal_map.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/messages/option_words.h"
#include "host/image/image_reader.h"
#include "host/image/normals/encoding_detection.h"
#include "host/image/normals/flat_map.h"
#include "host/image/normals/height_field.h"
#include "host/image/normals/image_survey.h"
#include "host/image/normals/normal_decode.h"
#include "host/image/normals/seam.h"

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

std::string step_text(const SeamStep& step) {
  return fmt::format(
      "the step across its border is {:.3g} rms, steps inside are {:.3g} in the median and {:.3g} at most", step.border,
      step.median, step.largest);
}

struct Direction {
  const char* name;    // "s (x)"
  const char* option;  // "swrap"
  const SeamStep& step;
  WrapOrigin origin;
};

// Nobody said that it repeats, and it does not seem to.
bool is_doubtful(const Direction& direction, WrapMode said) {
  return direction.step.is_seam() && direction.origin == WrapOrigin::kDefault && said == WrapMode::kPeriodic;
}

// The mode of one direction, `said` where it is not to be found; and what was found.
WrapMode resolved_wrap(WrapMode said, const Direction& direction, DetectedEncoding& found) {
  if (direction.origin != WrapOrigin::kFound) return said;
  const WrapMode mode = direction.step.is_seam() ? WrapMode::kClamp : WrapMode::kPeriodic;
  found.reason += fmt::format("; {} along {}: {}", wrap_mode_name(mode), direction.name, step_text(direction.step));
  return mode;
}

// Of one direction or of both, in one warning.
void warn_of_seams(const std::vector<Direction>& doubtful, DetectedEncoding& found) {
  if (doubtful.empty()) return;
  std::string text = "it is taken to repeat, but does not seem to:";
  for (const Direction& one : doubtful)
    text += fmt::format("{} along {} {}", &one == &doubtful.front() ? "" : ";", one.name, step_text(one.step));
  text += advice(fmt::format(
      ". <{0} clamp> ends it at its border, <{0} auto> lets the map decide, <{0} periodic> says that it repeats",
      doubtful.size() > 1 ? "wrap" : doubtful.front().option));
  found.warnings.push_back(text);
}

// The settings with the wrap modes that hold.
NormalMapSettings with_wrap(NormalMapSettings settings, const RawImage& image, DetectedEncoding& found) {
  const MapSeams seams = measure_seams(image);
  const Direction s{"s (x)", "swrap", seams.s, settings.wrap_s_origin};
  const Direction t{"t (y)", "twrap", seams.t, settings.wrap_t_origin};
  std::vector<Direction> doubtful;
  if (is_doubtful(s, settings.wrap_s)) doubtful.push_back(s);
  if (is_doubtful(t, settings.wrap_t)) doubtful.push_back(t);
  warn_of_seams(doubtful, found);
  settings.wrap_s = resolved_wrap(settings.wrap_s, s, found);
  settings.wrap_t = resolved_wrap(settings.wrap_t, t, found);
  return settings;
}

}  // namespace

NormalMapRows read_normal_map_rows(const std::string& path, const NormalMapSettings& settings, const SpillPolicy& spill,
                                   int threads, Progress* progress) {
  check_settings(settings);
  progress_stage(progress, "read " + path);
  ImageReader reader(path, {settings.texel_count_max, threads, spill.band_rows});
  const RawImageInfo info = reader.info();
  RawImage image(info, spill);
  ImageSurvey survey(info, likely_encodings(info, settings));
  const auto keep = [&](const RawBand& band) {
    image.write(band);
    survey.add(band);
  };
  reader.read(keep, progress);
  progress_stage(progress, "find the encoding");
  DetectedEncoding encoding = detect_encoding(path, image, survey, settings, threads);
  check_finite(path, survey, info.width, settings);
  const NormalMapSettings wrapped = with_wrap(settings, image, encoding);
  NormalMapRows map =
      encoding.is_height_field
          ? normals_from_heights(path, image, survey.nonfinite_count(), wrapped, spill, threads, progress)
          : decode_normals(path, image, encoding.vectors, wrapped, spill, threads, progress);
  map.report.wrap_s = wrapped.wrap_s;
  map.report.wrap_t = wrapped.wrap_t;
  if (!encoding.is_height_field) map.report.encoding = encoding.description;
  map.report.format = info.format;
  map.report.encoding_reason = encoding.reason;
  // Heights that are all alike but for a small scale are warned of already, and a ramp of heights is a surface.
  const Flatness flatness = flatness_of(map.normals);
  if (!encoding.is_height_field || (flatness == Flatness::kFlat && map.report.warnings.empty()))
    if (const std::string note = flat_note(flatness); !note.empty()) map.report.warnings.push_back(note);
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
