// SPDX-License-Identifier: Apache-2.0
// Reads the file, detects the meaning of its values, decodes them, and then repairs texels. The repair comes last,
// because it must not change the statistics.
#include "host/formats/image/normals/normal_map.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "host/formats/image/image_reader.h"
#include "host/formats/image/normals/encoding_detection.h"
#include "host/formats/image/normals/flat_map.h"
#include "host/formats/image/normals/height_dequantize.h"
#include "host/formats/image/normals/height_field.h"
#include "host/formats/image/normals/image_survey.h"
#include "host/formats/image/normals/normal_decode.h"
#include "host/formats/image/normals/seam.h"
#include "host/formats/image/normals/tile_set.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/option_words.h"

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
      "the step across its border has an rms value of {:.3g}, but steps inside the map have a median of {:.3g} and a "
      "maximum of {:.3g}",
      step.border, step.median, step.largest);
}

struct Direction {
  const char* name;    // name for messages, such as "s (x)"
  const char* option;  // name of the option, such as "swrap"
  const SeamStep& step;
  WrapOrigin origin;
  bool has_neighbour;  // true if a tile of the set continues the map there
};

// Returns whether the map repeats only by default, although its border suggests that it should not repeat.
bool is_doubtful(const Direction& direction, WrapMode said) {
  return direction.step.is_seam() && direction.origin == WrapOrigin::kDefault && said == WrapMode::kPeriodic;
}

// Returns the mode of one direction. The mode is `said`, unless the map itself decides. In that case, adds the decision
// to the reason.
WrapMode resolved_wrap(WrapMode said, const Direction& direction, DetectedEncoding& found) {
  if (direction.origin != WrapOrigin::kFound) return said;
  const WrapMode mode = direction.step.is_seam() ? WrapMode::kClamp : WrapMode::kPeriodic;
  found.reason += fmt::format("; {} along {}: {}", wrap_mode_name(mode), direction.name, step_text(direction.step));
  return mode;
}

// Warns about one or both directions in one warning.
void warn_of_seams(const std::vector<Direction>& doubtful, DetectedEncoding& found) {
  if (doubtful.empty()) return;
  std::string text = "it is assumed to repeat, but it probably does not:";
  for (const Direction& one : doubtful)
    text += fmt::format("{} along {} {}", &one == &doubtful.front() ? "" : ";", one.name, step_text(one.step));
  text += advice(fmt::format(
      ". <{0} clamp> ends it at its border, <{0} auto> lets the map decide, <{0} periodic> confirms that it repeats",
      doubtful.size() > 1 ? "wrap" : doubtful.front().option));
  found.warnings.push_back(text);
}

// Returns the settings with the final wrap modes.
NormalMapSettings with_wrap(NormalMapSettings settings, const Direction& s, const Direction& t,
                            DetectedEncoding& found) {
  std::vector<Direction> doubtful;
  if (is_doubtful(s, settings.wrap_s)) doubtful.push_back(s);
  if (is_doubtful(t, settings.wrap_t)) doubtful.push_back(t);
  warn_of_seams(doubtful, found);
  settings.wrap_s = resolved_wrap(settings.wrap_s, s, found);
  settings.wrap_t = resolved_wrap(settings.wrap_t, t, found);
  return settings;
}

Direction direction_s(const MapSeams& seams, const NormalMapSettings& settings, bool has_neighbour) {
  return {"s (x)", "swrap", seams.s, settings.wrap_s_origin, has_neighbour};
}
Direction direction_t(const MapSeams& seams, const NormalMapSettings& settings, bool has_neighbour) {
  return {"t (y)", "twrap", seams.t, settings.wrap_t_origin, has_neighbour};
}

// With wrap "auto", a map that continues in another tile does not repeat, even if its other end matches.
void report_wrap(const NormalMapSettings& wrapped, const Direction& s, const Direction& t, NormalMapReport& report) {
  const auto mode = [](const Direction& direction, WrapMode resolved) {
    return direction.has_neighbour && direction.origin == WrapOrigin::kFound ? WrapMode::kClamp : resolved;
  };
  report.wrap_s = mode(s, wrapped.wrap_s);
  report.wrap_t = mode(t, wrapped.wrap_t);
}

// The numbers of a file and their statistics.
struct ReadImage {
  RawImage image;
  ImageSurvey survey;
};

ReadImage read_image(const std::string& path, const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                     Progress* progress) {
  progress_stage(progress, "read " + path);
  ImageReader reader(path, {settings.texel_count_max, threads, spill.band_rows});
  const RawImageInfo info = reader.info();
  ReadImage read{RawImage(info, spill), ImageSurvey(info, likely_encodings(info, settings))};
  const auto keep = [&](const RawBand& band) {
    read.image.write(band);
    read.survey.add(band);
  };
  reader.read(keep, progress);
  return read;
}

// Returns the direction of green found in one tile. Returns nullopt if the direction is unknown, or if the tile is not
// a normal map or cannot be read. The bake of that tile reports such a fault.
std::optional<GreenAxis> green_of_map(const std::string& path, const NormalMapSettings& settings,
                                      const SpillPolicy& spill, int threads, Progress* progress) {
  std::optional<GreenAxis> green;
  try {
    const ReadImage read = read_image(path, settings, spill, threads, progress);
    detect_encoding(path, read.image, read.survey, settings, threads, [&](std::optional<GreenAxis> own) {
      green = own;
      return own;
    });
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kEnvironment) throw;
  }
  return green;
}

// Finds the direction of green in the other tiles of a set, and records in `record` which tile decided it.
GreenOfSet green_of_set(const NormalMapSettings& settings, const SpillPolicy& spill, int threads, Progress* progress,
                        std::string& record) {
  if (settings.tiles == nullptr) return {};
  return [&settings, &spill, &record, threads, progress](std::optional<GreenAxis> own) {
    TileSet& set = *settings.tiles;
    const TileSet::Green green = set.green([&](const std::string& tile) {
      return tile == settings.tile ? own : green_of_map(set.path(tile), settings, spill, threads, progress);
    });
    record = with_green("", set, green);
    return green.axis;
  };
}

// Chooses the neighbouring tile. If there is no such tile, chooses the side that the wrap mode gives.
HeightSide side_of(const HeightSide& neighbour, const HeightSide& repeated, const HeightSide& wrapped) {
  if (neighbour.beyond != HeightSide::Beyond::kEnd) return neighbour;
  return wrapped.beyond == HeightSide::Beyond::kWrapped ? repeated : wrapped;
}

HeightSides sides_of(const TileSurroundings& around, WrapMode wrap_s, WrapMode wrap_t) {
  const HeightSides &near = around.neighbours, &far = around.repeated, wrapped = wrapped_sides(wrap_s, wrap_t);
  return {side_of(near.left, far.left, wrapped.left), side_of(near.right, far.right, wrapped.right),
          side_of(near.above, far.above, wrapped.above), side_of(near.below, far.below, wrapped.below)};
}

TileSurroundings surroundings_of(const RawImageInfo& info, HeightCoding coding, const NormalMapSettings& settings,
                                 const SpillPolicy& spill) {
  if (settings.tiles == nullptr) {
    TileSurroundings alone;
    alone.repeated = wrapped_sides(WrapMode::kPeriodic, WrapMode::kPeriodic);
    return alone;
  }
  const int depth = settings.dequantize ? kDequantizeMargin : 1;
  const auto may_repeat = [](WrapMode mode, WrapOrigin origin) {
    return mode == WrapMode::kPeriodic || origin == WrapOrigin::kFound;
  };
  const TileRepeats repeats = {may_repeat(settings.wrap_s, settings.wrap_s_origin),
                               may_repeat(settings.wrap_t, settings.wrap_t_origin)};
  return tile_surroundings(*settings.tiles, settings.tile, info, repeats, {coding, depth, settings.fix_nan}, spill);
}

NormalMapRows read_heights(const std::string& path, const ReadImage& read, DetectedEncoding& encoding,
                           const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                           Progress* progress) {
  const std::int64_t nonfinite_count = read.survey.nonfinite_count();
  const TileSurroundings around = surroundings_of(read.image.info(), encoding.heights.coding, settings, spill);
  const MapSeams seams = measure_seams(
      HeightSurface(read.image, encoding.heights, nonfinite_count == 0, settings.fix_nan, around.repeated));
  const Direction s = direction_s(seams, settings, around.has_neighbour_s),
                  t = direction_t(seams, settings, around.has_neighbour_t);
  const NormalMapSettings wrapped = with_wrap(settings, s, t, encoding);
  NormalMapRows map = normals_from_heights(
      path, {read.image, encoding.heights, nonfinite_count, sides_of(around, wrapped.wrap_s, wrapped.wrap_t)}, wrapped,
      spill, threads, progress);
  if (!around.text.empty()) map.report.encoding += ", " + around.text;
  map.report.tiles = around.record;
  map.report.warnings.insert(map.report.warnings.begin(), around.warnings.begin(), around.warnings.end());
  report_wrap(wrapped, s, t, map.report);
  return map;
}

NormalMapRows read_vectors(const std::string& path, const ReadImage& read, DetectedEncoding& encoding,
                           const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                           Progress* progress) {
  const auto has_neighbour = [&](TileSide a, TileSide b) {
    const auto is_there = [&](TileSide side) {
      return settings.tiles->beside(settings.tile, side).kind == TileBeside::Kind::kNeighbour;
    };
    return settings.tiles != nullptr && (is_there(a) || is_there(b));
  };
  const MapSeams seams = measure_seams(read.image);
  const Direction s = direction_s(seams, settings, has_neighbour(TileSide::kLeft, TileSide::kRight)),
                  t = direction_t(seams, settings, has_neighbour(TileSide::kAbove, TileSide::kBelow));
  const NormalMapSettings wrapped = with_wrap(settings, s, t, encoding);
  NormalMapRows map = decode_normals(path, read.image, encoding.vectors, wrapped, spill, threads, progress);
  map.report.encoding = encoding.description;
  report_wrap(wrapped, s, t, map.report);
  return map;
}

}  // namespace

NormalMapRows read_normal_map_rows(const std::string& path, const NormalMapSettings& settings, const SpillPolicy& spill,
                                   int threads, Progress* progress) {
  check_settings(settings);
  const ReadImage read = read_image(path, settings, spill, threads, progress);
  const RawImageInfo& info = read.image.info();
  progress_stage(progress, "find the encoding");
  std::string record;
  DetectedEncoding encoding = detect_encoding(path, read.image, read.survey, settings, threads,
                                              green_of_set(settings, spill, threads, progress, record));
  check_finite(path, read.survey, info.width, settings);
  NormalMapRows map = encoding.is_height_field ? read_heights(path, read, encoding, settings, spill, threads, progress)
                                               : read_vectors(path, read, encoding, settings, spill, threads, progress);
  if (!encoding.is_height_field) map.report.tiles = record;
  map.report.format = info.format;
  map.report.is_height_field = encoding.is_height_field;
  map.report.encoding_reason = encoding.reason;
  // Equal heights with a small scale already cause a warning, and a ramp of heights is a surface.
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
