// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/filter_benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <regex>
#include <utility>

#include <glm/geometric.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/render/picture_error.h"
#include "runtime_gl/render/renderer.h"
#include "tools/lab/bench/measuring/bake_programs.h"
#include "tools/lab/bench/measuring/horizon_plane.h"
#include "tools/lab/bench/measuring/measured_program.h"
#include "tools/lab/bench/measuring/scratch_folder.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr float kPlaneSide = 60.0f;
constexpr float kMapRepeats = 40.0f;  // repetitions of the map across the plane
constexpr int kTaps[] = {1, 2, 4, 16};
constexpr float kBiases[] = {0.0f, -0.25f, -0.5f, -0.79f};
constexpr int kShadedTaps[] = {2, 4};
constexpr int kEvaluations[] = {1, 2, 4, 8, 16};
constexpr float kEvaluatedBiases[] = {-0.5f, -0.79f};
constexpr int kFlickerEvaluations = 4;  // motions are drawn only with this number of evaluations
constexpr std::size_t kTimedMaps = 4;
constexpr std::size_t kFlickerEvery = 4;  // motions are drawn only for every fourth map, because they take the most
                                          // time
constexpr int kTimedRuns = 3;
constexpr int kFrameCount = 3;  // number of frames per motion

// Returns the view of `tools/lab/reproduce maps`.
gl::RenderScene plane_view() {
  gl::RenderScene scene;
  scene.uv_scale = kMapRepeats;
  scene.brdf.exponent = 100.0f;
  scene.brdf.diffuse = glm::vec3(0.4f);
  scene.brdf.specular = glm::vec3(0.15f);
  return scene;
}

struct FilterSetting {
  int taps;
  float bias;
  bool shades_taps;
  int evaluations = 0;  // evaluations of light per pixel; 0 if the number of taps determines it

  gl::TextureFilter filter() const { return {taps, bias, shades_taps, false, evaluations}; }
  bool flickers() const {
    return evaluations == 0 || (evaluations == kFlickerEvaluations && bias == kEvaluatedBiases[0]);
  }
  Json row(const std::string& method) const {
    return {
        {"method", method}, {"taps", taps}, {"bias", bias}, {"shades_taps", shades_taps}, {"evaluations", evaluations}};
  }
};

std::vector<FilterSetting> all_settings() {
  std::vector<FilterSetting> settings;
  for (const int taps : kTaps)
    for (const float bias : kBiases) settings.push_back({taps, bias, false});
  for (const int taps : kShadedTaps)
    for (const float bias : kBiases) settings.push_back({taps, bias, true});
  for (const int evaluations : kEvaluations)
    for (const float bias : kEvaluatedBiases) settings.push_back({kTapCountDefault, bias, false, evaluations});
  return settings;
}

// Returns a camera that moves forwards, moves to the side or turns. The picture moves by a fraction of a pixel up to a
// few pixels per frame.
gl::RenderScene moved_view(const std::string& motion, int frame) {
  gl::RenderScene scene = plane_view();
  const auto t = static_cast<float>(frame);
  gl::Camera& camera = scene.camera;
  if (motion == "zoom") {
    const glm::vec3 ahead = camera.target - camera.eye;
    camera.eye += 0.01f * t * ahead;
    camera.target += 0.01f * t * ahead;
  } else if (motion == "pan") {
    camera.eye.x += 0.003f * t;
    camera.target.x += 0.003f * t;
  } else {
    const float angle = 0.004f * t;
    const glm::vec3 ahead = camera.target - camera.eye;
    camera.target = camera.eye + glm::vec3(ahead.x * std::cos(angle) + ahead.y * std::sin(angle),
                                           ahead.y * std::cos(angle) - ahead.x * std::sin(angle), ahead.z);
  }
  return scene;
}

constexpr const char* kMotions[] = {"zoom", "pan", "turn"};

struct MapFile {
  std::string name, path;
};

// Finds the same maps as tools/lab/papers/maps.py does.
std::vector<MapFile> find_maps(const FilterBenchmarkOptions& options, const ScratchFolder& folder, Progress* progress) {
  std::vector<MapFile> maps;
  if (options.maps.empty()) {
    maps.push_back({"four quarters", make_map_file(folder.path(), options.map_size, progress)});
    return maps;
  }
  const std::regex pattern("(pm_\\d+|.*(normal|_norm|_nm?|flakes5n))\\.(png|jpg|webp)");
  for (const auto& entry : std::filesystem::directory_iterator(options.maps))
    if (const std::string name = entry.path().filename().string(); std::regex_match(name, pattern))
      maps.push_back({entry.path().stem().string(), entry.path().string()});
  if (maps.empty()) throw Error(ErrorCode::kInput, options.maps + ": has no normal maps");
  std::sort(maps.begin(), maps.end(), [](const MapFile& a, const MapFile& b) { return a.name < b.name; });
  if (maps.size() > static_cast<std::size_t>(options.maps_max)) maps.resize(static_cast<std::size_t>(options.maps_max));
  return maps;
}

// If the map's statistics do not show the direction of green, assumes that green points up.
MovmfMipmap bake_and_read(const FilterBenchmarkOptions& options, const ScratchFolder& folder, const MapFile& map,
                          int lobe_count, Progress* progress) {
  const std::string file = folder / "lobes.ndf.exr";
  BakeCommandOptions bake;
  bake.lobes = lobe_count;
  bake.appended = {"--no-measure", "--force"};
  if (!options.device.empty()) bake.appended.insert(bake.appended.end(), {"--device", options.device});
  run_to_disk(multum_bake_command(map.path, file, bake), file, progress);
  MovmfMipmap mipmap = read_movmf_mipmap(file);
  std::filesystem::remove(file);
  return mipmap;
}

// A method that draws a map, with any filter.
struct Method {
  std::string name;
  gl::Material* material;
  std::optional<gl::Baseline> baseline;  // the baseline that NormalMaterial draws
  bool flickers;                         // whether flicker is also measured
};

class MapStudy {
 public:
  MapStudy(const FilterBenchmarkOptions& options, const gl::GlFunctions& functions, const gl::Mesh& mesh,
           gl::Renderer& large, gl::Renderer& small, Progress* progress)
      : options_(options), functions_(functions), mesh_(mesh), large_(large), small_(small), progress_(progress) {}

  Json measure(const ScratchFolder& folder, const MapFile& map, std::size_t number, ContentHash& hash) {
    std::vector<std::unique_ptr<gl::MovmfMaterial>> lobes;
    std::vector<Method> methods;
    gl::NormalImage image;
    for (const int count : options_.lobe_counts) {
      const MovmfMipmap mipmap = bake_and_read(options_, folder, map, count, progress_);
      if (image.normals.empty()) image = gl::finest_normals(mipmap);
      lobes.push_back(std::make_unique<gl::MovmfMaterial>(functions_, mipmap, 1.0f));
      methods.push_back({fmt::format("{} lobes", count), lobes.back().get(), std::nullopt, count == 4});
    }
    gl::NormalMaterial averages(functions_, image, gl::NormalMaterial::Sampling::kMipmapped, 1.0f);
    methods.push_back({"LEAN", &averages, gl::Baseline::kLeanJacobian, true});
    methods.push_back({"Toksvig", &averages, gl::Baseline::kToksvig, true});
    methods.push_back({"averaged normals", &averages, gl::Baseline::kMip, true});
    Json result = {{"map", map.name}, {"width", image.width}, {"height", image.height}};
    measure_errors(image, methods, averages, number < kTimedMaps, hash, result);
    if (number % kFlickerEvery == 0) measure_flicker(image, methods, averages, result);
    return result;
  }

 private:
  gl::Picture reference(gl::Renderer& renderer, const gl::Material& material, const gl::RenderScene& scene,
                        double noise) const {
    return renderer.draw_reference(mesh_, material, scene, {0, noise, gl::PixelFilter::kBox});
  }

  void measure_errors(const gl::NormalImage& image, const std::vector<Method>& methods, gl::NormalMaterial& averages,
                      bool is_timed, ContentHash& hash, Json& result) {
    using Sampling = gl::NormalMaterial::Sampling;
    const gl::NormalMaterial facets(functions_, image, Sampling::kNearest, 1.0f);
    const gl::NormalMaterial blended(functions_, image, Sampling::kBlended, 1.0f);
    gl::RenderScene scene = plane_view();
    const gl::Picture exact = reference(large_, facets, scene, options_.noise_max);
    const gl::Picture smooth = reference(large_, blended, scene, 2.0 * options_.noise_max);
    result["samples"] = exact.sample_count;
    result["noise"] = exact.noise;
    result["samples_blended"] = smooth.sample_count;
    result["noise_blended"] = smooth.noise;
    Json rows = Json::array();
    for (const FilterSetting& setting : all_settings()) {
      scene.filter = setting.filter();
      for (const Method& method : methods) {
        if (method.baseline) averages.set_baseline(*method.baseline);
        const gl::FloatImage picture = large_.draw_once(mesh_, *method.material, scene);
        hash.update(picture.rgba.data(), picture.rgba.size() * sizeof(float));
        Json row = setting.row(method.name);
        row["error"] = gl::picture_error(picture, exact.image).relative_l1;
        row["error_blended"] = gl::picture_error(picture, smooth.image).relative_l1;
        row["frame_processor_ms"] = is_timed ? Json(frame_processor_ms(method, scene)) : Json();
        rows.push_back(row);
        progress_advance(progress_, 0);
      }
    }
    result["pictures"] = rows;
  }

  // Measures the processor time over all threads several times, and returns the lowest value. Other programs hardly
  // affect this value.
  double frame_processor_ms(const Method& method, const gl::RenderScene& scene) {
    double least = 1e30;
    for (int i = 0; i < kTimedRuns; ++i) {
      const std::clock_t begin = std::clock();
      const int frames = large_.draw(mesh_, *method.material, scene).frame_count;
      const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      least = std::min(least, 1e3 * seconds / frames);
    }
    return least;
  }

  // Returns the mean over neighbouring frames of sum |(f' - f) - (t' - t)| / sum t, where f is a frame and t is its
  // reference.
  static double flicker_of(const std::vector<gl::FloatImage>& frames, const std::vector<gl::FloatImage>& references) {
    double sum = 0.0;
    for (std::size_t i = 0; i + 1 < frames.size(); ++i) {
      double change = 0.0, total = 0.0;
      for (std::size_t k = 0; k < frames[i].rgba.size(); ++k) {
        if (k % 4 == 3) continue;
        change += std::abs(static_cast<double>(frames[i + 1].rgba[k] - frames[i].rgba[k]) -
                           static_cast<double>(references[i + 1].rgba[k] - references[i].rgba[k]));
        total += static_cast<double>(references[i].rgba[k]);
      }
      sum += change / total;
    }
    return sum / static_cast<double>(frames.size() - 1);
  }

  void measure_flicker(const gl::NormalImage& image, const std::vector<Method>& methods, gl::NormalMaterial& averages,
                       Json& result) {
    const gl::NormalMaterial facets(functions_, image, gl::NormalMaterial::Sampling::kNearest, 1.0f);
    Json rows = Json::array();
    for (const char* const motion : kMotions) {
      std::vector<gl::FloatImage> references;
      for (int frame = 0; frame < kFrameCount; ++frame)
        references.push_back(reference(small_, facets, moved_view(motion, frame), 3.0 * options_.noise_max).image);
      for (const FilterSetting& setting : all_settings())
        for (const Method& method : methods) {
          if (!method.flickers || !setting.flickers()) continue;
          if (method.baseline) averages.set_baseline(*method.baseline);
          std::vector<gl::FloatImage> frames;
          for (int frame = 0; frame < kFrameCount; ++frame) {
            gl::RenderScene scene = moved_view(motion, frame);
            scene.filter = setting.filter();
            frames.push_back(small_.draw_once(mesh_, *method.material, scene));
          }
          Json row = setting.row(method.name);
          row["motion"] = motion;
          row["flicker"] = flicker_of(frames, references);
          rows.push_back(row);
          progress_advance(progress_, 0);
        }
    }
    result["motions"] = rows;
  }

  const FilterBenchmarkOptions& options_;
  const gl::GlFunctions& functions_;
  const gl::Mesh& mesh_;
  gl::Renderer& large_;
  gl::Renderer& small_;
  Progress* progress_;
};

}  // namespace

Json run_filter_benchmark(const FilterBenchmarkOptions& options, Progress* progress) {
  const auto context = gl::make_headless_context(options.context, gl::DebugOutput::kOff);
  const ScratchFolder folder(options.folder);
  const gl::Mesh mesh(context->functions(), horizon_plane(kPlaneSide));
  gl::Renderer large(context->functions(), options.width, options.height);
  gl::Renderer small(context->functions(), std::max(options.width / 2, 1), std::max(options.height / 2, 1));
  MapStudy study(options, context->functions(), mesh, large, small, progress);
  Json maps = Json::array();
  ContentHash hash;
  for (const MapFile& map : find_maps(options, folder, progress)) {
    fmt::print(stderr, "{}\n", map.name);
    maps.push_back(study.measure(folder, map, maps.size(), hash));
  }
  return {{"device", context->description()},
          {"width", options.width},
          {"height", options.height},
          {"noise_max", options.noise_max},
          {"repetitions", 3},
          {"result_hash", hash.finish()},
          {"maps", maps}};
}

}  // namespace multum::bench
