// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/frames_benchmark.h"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/normal_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/render/renderer.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/bake_programs.h"
#include "tools/lab/bench/measuring/horizon_plane.h"
#include "tools/lab/bench/measuring/measured_program.h"
#include "tools/lab/bench/measuring/scratch_folder.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLobesMax = 8;
constexpr float kAnisotropies[] = {1.0f, 16.0f};

// Makes the default picture of `multum-view`, which shows sixty repetitions of the map across a plane at a grazing
// angle.
constexpr float kRepeats = 60.0f;

gl::RenderScene plane_scene() {
  gl::RenderScene scene;
  scene.uv_scale = kRepeats;
  scene.brdf.exponent = 100.0f;
  scene.filter.is_drivers = true;  // the benchmark measures the driver's anisotropic filter
  return scene;
}

struct Baked {
  std::string name, file;
  std::vector<std::string> options;
  std::unique_ptr<gl::Material> (*read)(const gl::GlFunctions& functions, const std::string& file, float anisotropy);
};

std::unique_ptr<gl::Material> read_lobes(const gl::GlFunctions& functions, const std::string& file, float anisotropy) {
  return std::make_unique<gl::MovmfMaterial>(functions, read_movmf_mipmap(file), anisotropy);
}

std::unique_ptr<gl::Material> read_moments(const gl::GlFunctions& functions, const std::string& file,
                                           float anisotropy) {
  auto material = std::make_unique<gl::MomentMaterial>(functions, read_moment_mipmap(file), anisotropy);
  material->set_shading(gl::MomentShading::kLeanJacobian);
  return material;
}

std::unique_ptr<gl::Material> read_harmonics(const gl::GlFunctions& functions, const std::string& file,
                                             float anisotropy) {
  return std::make_unique<gl::ShMaterial>(functions, read_sh_mipmap(file), anisotropy);
}

// Contains a method that is drawn, and its frame times.
struct Subject {
  std::string name;
  float anisotropy;
  std::uint64_t gpu_bytes;
  std::unique_ptr<gl::Material> material;
  std::vector<double> draw_ms, ratios;
};

std::vector<Baked> all_files(const ScratchFolder& folder) {
  std::vector<Baked> files;
  for (int lobes = 1; lobes <= kLobesMax; ++lobes)
    files.push_back({fmt::format("{} lobe{}", lobes, lobes == 1 ? "" : "s"),
                     folder / fmt::format("{}.ndf.exr", lobes),
                     {"--lobes", std::to_string(lobes)},
                     read_lobes});
  files.push_back({"moments (LEAN)", folder / "moments.ndf.exr", {"--ndf", "moments"}, read_moments});
  for (const int order : {4, 8})
    files.push_back({fmt::format("harmonics, order {}", order),
                     folder / fmt::format("sh{}.ndf.exr", order),
                     {"--ndf", "sh", "--sh-order", std::to_string(order)},
                     read_harmonics});
  return files;
}

void bake_all(const std::vector<Baked>& files, const std::string& map, const FramesBenchmarkOptions& options,
              Progress* progress) {
  for (const Baked& baked : files) {
    std::vector<std::string> more = {"--no-measure"};
    more.insert(more.end(), baked.options.begin(), baked.options.end());
    if (!options.device.empty()) more.insert(more.end(), {"--device", options.device});
    BakeCommandOptions bake;
    bake.lobes = 0;
    bake.appended = more;
    run_to_disk(multum_bake_command(map, baked.file, bake), baked.file, progress);
  }
}

std::vector<Subject> all_subjects(const gl::GlFunctions& functions, const std::vector<Baked>& files, float anisotropy) {
  std::vector<Subject> subjects;
  const gl::NormalImage image = gl::finest_normals(read_movmf_mipmap(files[0].file));
  auto toksvig =
      std::make_unique<gl::NormalMaterial>(functions, image, gl::NormalMaterial::Sampling::kMipmapped, anisotropy);
  toksvig->set_baseline(gl::Baseline::kToksvig);
  subjects.push_back({"averaged normals, Toksvig",
                      anisotropy,
                      default_gpu_bytes(image.width, image.height),
                      std::move(toksvig),
                      {},
                      {}});
  for (const Baked& baked : files)
    subjects.push_back(
        {baked.name, anisotropy, baked_gpu_bytes(baked.file), baked.read(functions, baked.file, anisotropy), {}, {}});
  return subjects;
}

// Draws all subjects of one anisotropy alternately and measures their times. Ratios are relative to the first subject.
void time_frames_in_turns(const gl::GlFunctions& functions, const FramesBenchmarkOptions& options,
                          std::vector<Subject>& subjects, ContentHash& hash, Progress* progress) {
  const gl::Mesh mesh(functions, horizon_plane(kRepeats));
  gl::Renderer renderer(functions, options.width, options.height);
  const gl::RenderScene scene = plane_scene();
  for (int turn = 0; turn <= options.repetitions; ++turn) {  // the first turn compiles shaders and is not measured
    double first = 0.0;
    for (Subject& subject : subjects) {
      const gl::Picture picture = renderer.draw(mesh, *subject.material, scene);
      if (turn == 0) {
        hash.update(picture.image.rgba.data(), picture.image.rgba.size() * sizeof(float));
        continue;
      }
      if (&subject == subjects.data()) first = picture.draw_time_ms;
      subject.draw_ms.push_back(picture.draw_time_ms);
      subject.ratios.push_back(picture.draw_time_ms / first);
      progress_advance(progress, 0);
    }
  }
}

}  // namespace

Json run_frames_benchmark(const FramesBenchmarkOptions& options, Progress* progress) {
  const auto context = gl::make_headless_context(options.context, gl::DebugOutput::kOff);
  const ScratchFolder folder(options.folder);
  const std::vector<Baked> files = all_files(folder);
  bake_all(files, make_map_file(folder.path(), options.size, progress), options, progress);
  Json rows = Json::array();
  ContentHash hash;
  for (const float anisotropy : kAnisotropies) {
    std::vector<Subject> subjects = all_subjects(context->functions(), files, anisotropy);
    time_frames_in_turns(context->functions(), options, subjects, hash, progress);
    for (const Subject& subject : subjects)
      rows.push_back({{"name", subject.name},
                      {"anisotropy", subject.anisotropy},
                      {"gpu_bytes", subject.gpu_bytes},
                      {"draw_ms", spread_json(spread_of(subject.draw_ms))},
                      {"ratio", spread_json(spread_of(subject.ratios))}});
  }
  return {{"device", context->description()},
          {"size", options.size},
          {"width", options.width},
          {"height", options.height},
          {"repetitions", options.repetitions},
          {"result_hash", hash.finish()},
          {"rows", rows}};
}

ResultView view_frames(const Json& result) {
  MarkdownTable table({"method", "anisotropy", "textures, MiB", "time per frame, ms", "ratio to Toksvig"});
  for (const Json& row : result.at("rows"))
    table.add({row.at("name").get<std::string>(), fmt::format("{:.0f}", row.at("anisotropy").get<double>()),
               rounded_text(row.at("gpu_bytes").get<double>() / (1 << 20)),
               spread_text(parse_spread(row.at("draw_ms"))), spread_text(parse_spread(row.at("ratio")))});
  return {"Frames",
          fmt::format("Pictures of {} x {} pixels show the four-quarter map of {} x {} texels with all levels. The map "
                      "is repeated {:.0f} times across a plane that runs to the horizon, with Blinn-Phong (s = 100) "
                      "and one light. The times were measured with the driver's timer (GL_TIME_ELAPSED). After one "
                      "untimed run, each method ran {} times, alternating with the other methods. Averaged normals are "
                      "drawn from two RGBA32F textures. Engines use BC5 normals and BC4 roughness instead, which draw "
                      "faster. The table lists the memory of these BC5 and BC4 textures.",
                      result.at("width").get<int>(), result.at("height").get<int>(), result.at("size").get<int>(),
                      result.at("size").get<int>(), static_cast<double>(kRepeats), result.at("repetitions").get<int>()),
          table.text()};
}

}  // namespace multum::bench
