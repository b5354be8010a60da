// SPDX-License-Identifier: Apache-2.0
// Implements multum-view play, which draws frames along a path through the parameters of a packed field, and decodes
// the field at the same time.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/fields/playback/parameter_path.h"
#include "host/fields/playback/recorded_path.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/parameters/parameter.h"
#include "runtime_gl/animation/field_player.h"
#include "runtime_gl/animation/textured_renderer.h"
#include "tools/multum_view/fields/animation_geometry.h"
#include "tools/multum_view/fields/debug_picture.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kFrames = 24, kFramesMax = 9999;  // file names of frames have four digits

std::string played_frame_path(const PlayOptions& options, int frame) {
  return (fs::path(options.folder) / fmt::format("frame_{:04}.{}", frame, options.writes_exr ? "exr" : "png")).string();
}

std::string statistics_path(const PlayOptions& options) {
  return (fs::path(options.folder) / "statistics.json").string();
}

std::size_t size_value(const char* option, const std::string& text) {
  const std::optional<std::int64_t> bytes = parse_size_text(text);
  if (!bytes) throw Error(ErrorCode::kUsage, fmt::format("{} '{}': expected a size, e.g. 800M or 2G", option, text));
  return static_cast<std::size_t>(*bytes);
}

gl::PlayerSettings player_settings(const PlayOptions& options) {
  gl::PlayerSettings settings;
  settings.playback.memory_max = size_value("--memory", options.memory);
  settings.playback.threads = options.threads;
  settings.playback.lifetime = static_cast<double>(options.lifetime);
  settings.playback.lifetime_factor = static_cast<double>(options.lifetime_factor);
  settings.upload_max = size_value("--upload", options.upload);
  settings.is_linear = options.is_linear;
  settings.waits = !options.draws_what_is_there;
  return settings;
}

/// Returns the parameter values of all frames.
std::vector<std::vector<double>> points_of(const PlayOptions& options, const ParameterPath& path) {
  const int count = options.frame_count > 0 ? options.frame_count : kFrames;
  std::vector<std::vector<double>> points;
  for (int frame = 0; frame < count; ++frame) {
    const double share = count > 1 ? static_cast<double>(frame) / (count - 1) : 0.0;
    points.push_back(path.at({static_cast<double>(frame) / static_cast<double>(options.rate), share}));
  }
  return points;
}

std::vector<std::vector<double>> points_of(const PlayOptions& options, const RecordedPath& path) {
  const double rate = static_cast<double>(options.rate);
  const double all = std::max(1.0, std::ceil(path.seconds() * rate));
  if (options.frame_count == 0 && all > kFramesMax)
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: {:g} s are {:.0f} frames, expected at most {}; choose fewer --frames or a lower --rate",
                    options.path, path.seconds(), all, kFramesMax));
  const int count = options.frame_count > 0 ? options.frame_count : static_cast<int>(all);
  std::vector<std::vector<double>> points;
  for (int frame = 0; frame < count; ++frame) points.push_back(path.at(frame / rate));
  return points;
}

std::vector<std::vector<double>> path_points(const PlayOptions& options, const std::vector<std::string>& names) {
  if (is_recorded_path(options.path)) return points_of(options, read_recorded_path(options.path, names));
  return points_of(options, ParameterPath(options.path, names));
}

void check_play_outputs(const PlayOptions& options, const std::string& geometry, std::size_t frame_count) {
  make_folder(options.folder);
  std::vector<std::string> inputs = {options.file, geometry}, outputs = {statistics_path(options)};
  if (is_recorded_path(options.path)) inputs.push_back(options.path);
  for (std::size_t frame = 0; frame < frame_count; ++frame)
    outputs.push_back(played_frame_path(options, static_cast<int>(frame)));
  if (!options.debug_picture.empty()) outputs.push_back(options.debug_picture);
  check_paths_differ(inputs, outputs);
  for (const std::string& output : outputs) check_writable(output);
}

/// Returns the quantile `p` of the values by the nearest-rank method, where `p` is in 0..1.
double quantile(std::vector<double> values, double p) {
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(p * static_cast<double>(values.size())) - 1.0;
  return values[static_cast<std::size_t>(std::clamp(rank, 0.0, static_cast<double>(values.size() - 1)))];
}

json times_json(const std::vector<double>& seconds) {
  return {{"p50_ms", 1e3 * quantile(seconds, 0.5)},
          {"p99_ms", 1e3 * quantile(seconds, 0.99)},
          {"max_ms", 1e3 * quantile(seconds, 1.0)}};
}

/// Draws the frames and records the time of each.
class PathPlayer {
 public:
  PathPlayer(const gl::GlFunctions& gl, const PlayOptions& options, const gl::PlayerSettings& settings)
      : gl_(gl),
        options_(options),
        settings_(settings),
        player_(gl, options.file, settings_),
        field_(player_.description().field),
        supersampling_(options.supersampling > 0 ? options.supersampling : field_.supersampling),
        renderer_(gl, field_.width, field_.height, supersampling_),
        geometry_(gl, field_, fs::path(options.file).parent_path().string()) {}

  gl::FloatImage draw(const std::vector<std::vector<double>>& points, std::size_t frame) {
    const std::vector<double>& point = points[frame];
    std::vector<std::vector<double>> ahead;
    for (std::size_t f = frame + 1; f < points.size() && ahead.size() < static_cast<std::size_t>(options_.ahead); ++f)
      ahead.push_back(points[f]);
    if (options_.is_cold) player_.forget_all();
    Stopwatch stopwatch;
    const gl::FrameReport report = player_.prepare(point, ahead);
    gl_.Finish();
    const double preparing = stopwatch.lap();
    gl::FloatImage picture = renderer_.draw(objects_at(point));
    note(point, report, preparing, stopwatch.lap());
    return picture;
  }

  json statistics() const {
    const PlaybackCounts counts = player_.counts();
    return {{"file", options_.file},
            {"path", options_.path},
            {"parameters", field_.parameters},
            {"supersampling", supersampling_},
            {"memory_max", settings_.playback.memory_max},
            {"bytes_most", counts.bytes_most},
            {"chunks_decoded", counts.chunks_decoded},
            {"images_decoded", counts.images_decoded},
            {"cancelled", counts.cancelled},
            {"forgotten", counts.forgotten},
            {"processor_seconds", {{"chunks", counts.chunk_seconds}, {"images", counts.image_seconds}}},
            {"preparing", times_json(preparing_)},
            {"drawing", times_json(drawing_)},
            {"damaged", player_.damaged()},
            {"frames", frames_json_}};
  }
  const std::vector<PlayedFrame>& frames() const { return frames_; }
  const gl::FieldPlayer& player() const { return player_; }

 private:
  std::vector<gl::TexturedObject> objects_at(const std::vector<double>& point) const {
    const SampleGrid& grid = player_.description().grid;
    const std::vector<double> here = clamped_point(grid, point);
    const glm::dmat4 camera = player_.camera(here);
    std::vector<gl::TexturedObject> objects;
    for (std::size_t i = 0; i < field_.objects.size(); ++i) {
      const glm::dmat4 place = matrix_at(
          grid, here, [&](std::size_t sample) { return geometry_.place(i, sample); }, place_between);
      objects.push_back({{&geometry_.mesh(i, player_.mapping(i)), object_to_clip(camera, place)}, player_.layers(i)});
    }
    return objects;
  }

  void note(const std::vector<double>& point, const gl::FrameReport& report, double preparing, double drawing) {
    const PlaybackCounts counts = player_.counts();
    frames_.push_back({report.layers, counts.images_decoded - before_.images_decoded,
                       counts.chunks_decoded - before_.chunks_decoded, counts.bytes, counts.bytes_most,
                       counts.chunk_seconds + counts.image_seconds - before_.chunk_seconds - before_.image_seconds});
    before_ = counts;
    preparing_.push_back(preparing);
    drawing_.push_back(drawing);
    std::size_t needed = 0, missing = 0, old = 0;
    for (const gl::LayerReport& layer : report.layers) {
      needed += layer.needed;
      missing += layer.missing;
      old += layer.is_old ? 1 : 0;
    }
    frames_json_.push_back({{"point", point},
                            {"images_needed", needed},
                            {"images_missing", missing},
                            {"layers_old", old},
                            {"textures_made", report.textures_made},
                            {"images_decoded", frames_.back().images_decoded},
                            {"chunks_decoded", frames_.back().chunks_decoded},
                            {"decoding_processor_ms", 1e3 * frames_.back().decoding_seconds},
                            {"uploaded_bytes", report.uploaded_bytes},
                            {"bytes", counts.bytes},
                            {"wait_ms", 1e3 * report.wait_seconds},
                            {"upload_ms", 1e3 * report.upload_seconds},
                            {"sum_ms", 1e3 * report.sum_seconds},
                            {"prepare_ms", 1e3 * preparing},
                            {"draw_ms", 1e3 * drawing}});
  }

  const gl::GlFunctions& gl_;
  const PlayOptions& options_;
  gl::PlayerSettings settings_;
  gl::FieldPlayer player_;
  const InferredManifest& field_;
  int supersampling_;
  gl::TexturedRenderer renderer_;
  AnimationGeometry geometry_;
  PlaybackCounts before_;
  std::vector<PlayedFrame> frames_;
  std::vector<double> preparing_, drawing_;
  json frames_json_ = json::array();
};

}  // namespace

void add_play_options(CLI::App& app, PlayOptions& options) {
  app.add_option("file", options.file, "packed field, *.mpt")->required();
  app.add_option(
         "--path", options.path,
         "set the value of each parameter, such as 'view=0..7,light=3.5+3.5*sin(t)', or FILE.json, a path that the "
         "player in a browser saved")
      ->required();
  app.add_option("-o,--output", options.folder, "folder for frame_0000.png and so on, and statistics.json")->required();
  app.add_option("--frames", options.frame_count,
                 fmt::format("draw this many frames (default: {}, or all of FILE.json)", kFrames))
      ->check(CLI::Range(1, kFramesMax));
  app.add_option("--rate", options.rate, "set the frames per second of the time t")
      ->check(number_in(0.001f, 1e6f))
      ->capture_default_str();
  app.add_option("--supersampling", options.supersampling,
                 "draw this many sub-pixels along each side of a pixel (default: from the field)")
      ->check(CLI::Range(1, 8));
  app.add_flag("--linear", options.is_linear,
               "interpolate linearly between samples along each parameter, instead of using the nearest sample");
  app.add_flag("--exr", options.writes_exr,
               "write frame_0000.exr and so on, with linear floats and the covered share of each pixel as alpha");
  app.add_flag("--no-wait", options.draws_what_is_there,
               "do not wait for images that are not decoded yet; pictures then depend on the speed of the machine");
  app.add_flag("--cold", options.is_cold,
               "discard all decoded data before each frame, to measure jumps along the path");
  app.add_option("--ahead", options.ahead, "also decode this many frames ahead on the path")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--memory", options.memory,
                 "limit the memory for decoded data, including GPU memory, to this size, such as 800M or 2G")
      ->capture_default_str();
  app.add_option("--upload", options.upload, "with --no-wait, send at most this many bytes per frame to the GPU")
      ->capture_default_str();
  app.add_option("--lifetime", options.lifetime, "keep an unused image of one sample for this many frames")
      ->check(number_in(0.0f, 1e6f))
      ->capture_default_str();
  app.add_option("--lifetime-factor", options.lifetime_factor,
                 "keep images this many times longer for each coarser level of the pyramid")
      ->check(number_in(1.0f, 64.0f))
      ->capture_default_str();
  app.add_option("--threads", options.threads, "decode with this many threads; 0 means one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--debug-picture", options.debug_picture, "write a picture of the playback with one column per frame");
  app.add_option("--exposure", options.exposure, "multiply the brightness of the frames by this")
      ->check(number_in(1e-6f, 1e6f))
      ->capture_default_str();
  add_context_option(app, options.context);
}

int play_field(const PlayOptions& options) {
  if (!is_packed_field(options.file))
    throw Error(ErrorCode::kInput, options.file + ": is not a packed field, expected a file of multum pack");
  if (!options.debug_picture.empty()) check_picture_path(options.debug_picture);
  const gl::PlayerSettings settings = player_settings(options);
  const InferredManifest field = PackedFieldFile(options.file).description().field;
  const std::vector<std::vector<double>> points = path_points(options, field.parameters);
  check_play_outputs(options, (fs::path(options.file).parent_path() / field.geometry_file).string(), points.size());
  keep_freed_memory();  // so that decoded images reuse memory
  const auto context = gl::make_headless_context(options.context, gl::DebugOutput::kOff);
  log_info(context->description());
  PathPlayer player(context->functions(), options, settings);
  for (std::size_t frame = 0; frame < points.size(); ++frame)
    write_picture(played_frame_path(options, static_cast<int>(frame)), player.draw(points, frame), options.exposure);
  write_text_file(statistics_path(options), json_text(player.statistics(), 2) + "\n");
  if (!options.debug_picture.empty())
    write_picture(options.debug_picture, debug_picture(player.frames(), settings.playback.memory_max), 1.0f);
  const PlaybackCounts counts = player.player().counts();
  print_shown(stdout, "%s: written: %zu frames; decoded %zu images of %zu chunks; used at most %zu bytes at once\n",
              options.folder.c_str(), points.size(), counts.images_decoded, counts.chunks_decoded, counts.bytes_most);
  const std::vector<std::string> damaged = player.player().damaged();
  if (damaged.empty()) return 0;
  std::string text = "damaged parts are left out, and everything else is drawn:";
  for (const std::string& what : damaged) text += "\n  " + what;
  throw Error(ErrorCode::kVerification, text);
}

}  // namespace multum
