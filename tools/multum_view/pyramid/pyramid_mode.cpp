// SPDX-License-Identifier: Apache-2.0
// Implements multum-view pyramid, which draws a surface whose colours come directly from a pyramid. It shows several
// lookups next to the reference, and measures how much highlights flicker (Williams 1983, sections 3 and 4).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/formats/asset/pyramid/reflectance_mapping.h"
#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/shown_text.h"
#include "runtime_gl/pyramid/pyramid_renderer.h"
#include "runtime_gl/render/picture_error.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum_view/modes.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/view_outputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

using gl::FloatImage;
using gl::PyramidLookup;

std::optional<PyramidLookup> lookup_of(const std::string& name) {
  if (name == "nearest") return PyramidLookup::kNearest;
  if (name == "bilinear") return PyramidLookup::kBilinear;
  if (name == "level") return PyramidLookup::kLevel;
  if (name == "driver") return PyramidLookup::kDriver;
  return std::nullopt;  // the reference
}

glm::vec3 vector_of(const nlohmann::json& json) {
  return {json.at(0).get<float>(), json.at(1).get<float>(), json.at(2).get<float>()};
}

/// Returns the lights from which a reflectance map was baked. If the map contains an environment, or more lights than a
/// shader supports, returns no lights, and the map's finest level is the best available reference.
std::optional<gl::PhongLights> baked_lights(const PyramidHeader& header, const std::string& path) {
  const nlohmann::json json = nlohmann::json::parse(header.map.provenance.settings, nullptr, false);
  if (!header.map.provenance.source_hash.empty()) return std::nullopt;
  try {
    gl::PhongLights lights;
    lights.exponent = json.at("exponent").get<float>();
    lights.diffuse = vector_of(json.at("diffuse"));
    lights.specular = vector_of(json.at("specular"));
    for (const nlohmann::json& light : json.at("lights"))
      lights.lights.push_back({vector_of(light.at("direction")), vector_of(light.at("irradiance"))});
    if (lights.lights.size() > gl::kLightCountMax) return std::nullopt;
    return lights;
  } catch (const nlohmann::json::exception&) {
    throw Error(ErrorCode::kInput,
                path + ": its settings contain no lights, expected the settings of `multum reflectance`");
  }
}

/// Places the camera far away in the direction of the map's viewer.
gl::Camera viewer_camera(const TriangleMesh& mesh, const ReflectanceFrame& frame, gl::Camera camera) {
  glm::vec3 low = mesh.positions[0], high = low;
  for (const glm::vec3& p : mesh.positions) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  constexpr float kFieldOfView = 8.0f;  // narrow, so that all view directions are similar, because the map has only one
  const float radius = std::max(0.5f * glm::length(high - low), 1e-6f);
  const float distance = radius / std::sin(glm::radians(0.5f * kFieldOfView));
  camera.fov_y_degrees = kFieldOfView;
  camera.target = 0.5f * (low + high);
  camera.eye = camera.target + distance * glm::vec3(frame.viewer);
  camera.up = glm::vec3(frame.up);
  camera.near_distance = distance - 1.5f * radius;
  camera.far_distance = distance + 1.5f * radius;
  return camera;
}

/// The surfaces that the pyramid colours.
struct Surfaces {
  gl::MeshData drawn;
  std::optional<gl::MeshData> finest;  // the reference's surface; the same as `drawn` if not set
};

class PyramidPictures {
 public:
  PyramidPictures(const PyramidOptions& options, const gl::RenderScene& scene, const gl::GlFunctions& gl,
                  const Pyramid& pyramid, const Surfaces& surfaces, std::optional<gl::PhongLights> lights)
      : options_(options),
        gl_(gl),
        pyramid_(pyramid),
        mesh_(gl, surfaces.drawn),
        by_normal_(pyramid.header.kind == PyramidKind::kReflectance),
        lights_(std::move(lights)),
        renderer_(gl, options.output.width(), options.output.height()) {
    if (surfaces.finest) finest_.emplace(gl, *surfaces.finest);
    scene_.camera = scene.camera;
    scene_.uv_scale = scene.uv_scale;
    scene_.level_bias = options.level_bias.value_or(by_normal_ ? gl::kEqualVarianceBias : 0.0f);
    if (!by_normal_) return;
    const ReflectanceFrame frame = parse_reflectance_frame(pyramid.header.map.provenance.settings, options.file);
    scene_.frame = {glm::vec3(frame.right), glm::vec3(frame.up), glm::vec3(frame.viewer)};
  }

  float level_bias() const { return scene_.level_bias; }

  FloatImage draw(const std::string& name, glm::vec2 shift) {
    const std::optional<PyramidLookup> lookup = lookup_of(name);
    gl::PyramidScene scene = scene_;
    if (lookup) {
      // If a pixel's footprint is a long ellipse, the driver makes several lookups along it, which together have the
      // right width.
      const bool is_long = *lookup == PyramidLookup::kDriver && options_.anisotropy > 1.0f;
      if (is_long && !options_.level_bias) scene.level_bias = 0.0f;
      scene.shift = shift;
      return renderer_.draw(mesh_, texture(*lookup), *lookup, by_normal_, scene);
    }
    const int side = std::max(1, static_cast<int>(std::lround(std::sqrt(options_.samples))));
    const PyramidLookup finest = by_normal_ ? PyramidLookup::kBilinear : PyramidLookup::kNearest;
    return gl::supersampled(side, [&](glm::vec2 offset) {
      scene.shift = shift + offset;
      const gl::Mesh& mesh = finest_ ? *finest_ : mesh_;
      return lights_ ? renderer_.draw_phong(mesh, *lights_, scene)
                     : renderer_.draw(mesh, texture(finest), finest, by_normal_, scene);
    });
  }

 private:
  const gl::Texture& texture(PyramidLookup lookup) {
    std::optional<gl::Texture>& made = textures_[static_cast<std::size_t>(lookup)];
    if (!made) made.emplace(gl::make_pyramid_texture(gl_, pyramid_, lookup, options_.anisotropy));
    return *made;
  }

  const PyramidOptions& options_;
  const gl::GlFunctions& gl_;
  const Pyramid& pyramid_;
  const gl::Mesh mesh_;
  std::optional<gl::Mesh> finest_;  // the surface of the reference, if it differs
  const bool by_normal_;
  const std::optional<gl::PhongLights> lights_;
  gl::PyramidRenderer renderer_;
  gl::PyramidScene scene_;
  std::array<std::optional<gl::Texture>, 4> textures_;
};

/// Measures the flicker of every lookup except the reference, in the order of the lookups. For the measurement, the
/// picture is shifted along a slanted line by one pixel in total.
std::vector<double> measure_flicker(const PyramidOptions& options, PyramidPictures& pictures) {
  std::vector<std::vector<FloatImage>> shifted(options.lookups.size());
  for (int k = 0; k < options.shifts; ++k) {
    const float t = static_cast<float>(k) / static_cast<float>(options.shifts) - 0.5f;
    for (std::size_t i = 0; i < options.lookups.size(); ++i)
      shifted[i].push_back(pictures.draw(options.lookups[i], {t, 0.37f * t}));
  }
  std::vector<double> flickers;
  for (const std::vector<FloatImage>& one : shifted) flickers.push_back(gl::flicker(one, shifted[0]));
  return flickers;
}

nlohmann::json print_rows(const std::vector<NamedPicture>& pictures, const std::vector<double>& flickers) {
  const bool has_reference = pictures[0].name == "reference";
  nlohmann::json rows = nlohmann::json::array();
  write_shown(stdout, fmt::format("{:10} {:>12} {:>10} {:>10}\n", "lookup", "relative L1", "RMSE", "flicker"));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    nlohmann::json row = {{"name", pictures[i].name}};
    std::string l1 = "-", rmse = "-", flicker = "-";
    if (has_reference && i > 0) {
      const gl::PictureError error = gl::picture_error(pictures[i].picture.image, pictures[0].picture.image);
      row["relative_l1"] = error.relative_l1;
      row["rmse"] = error.rmse;
      l1 = fmt::format("{:.2f} %", 100.0 * error.relative_l1);
      rmse = fmt::format("{:.5f}", error.rmse);
    }
    if (has_reference && i > 0 && !flickers.empty()) {
      row["flicker"] = flickers[i];
      flicker = fmt::format("{:.4f}", flickers[i]);
    }
    write_shown(stdout, fmt::format("{:10} {:>12} {:>10} {:>10}\n", pictures[i].name, l1, rmse, flicker));
    rows.push_back(row);
  }
  return rows;
}

/// Makes the surfaces that the pyramid colours, and the camera for them.
Surfaces make_surfaces(const PyramidOptions& options, const PyramidHeader& header, ViewScenes& scenes) {
  PictureOptions picture;
  picture.surface = options.surface;
  picture.camera = options.camera;
  picture.output = options.output;
  scenes = make_scenes(picture);
  if (header.kind != PyramidKind::kReflectance) return {make_mesh(picture, scenes), std::nullopt};
  std::optional<Pyramid> pyramid;
  if (!options.surface_pyramid.empty()) pyramid = read_surface_pyramid(options.surface_pyramid);
  const TriangleMesh mesh =
      pyramid ? to_triangle_mesh(surface_at_level(*pyramid, 0.0)) : read_mesh(options.surface.mesh);
  if (scenes.has_camera) {
    frame_mesh(mesh, pyramid ? options.surface_pyramid : options.surface.mesh, options.output, scenes);
  } else {
    const ReflectanceFrame frame = parse_reflectance_frame(header.map.provenance.settings, options.file);
    scenes.first.camera = viewer_camera(mesh, frame, scenes.first.camera);
  }
  if (!pyramid) return {to_mesh_data(mesh), std::nullopt};
  const double level = detail_level(options.detail, *pyramid, scenes.first.camera, options.output.height());
  const PyramidSurface drawn = surface_at_level(*pyramid, level);
  write_shown(stdout, fmt::format("level {:g}: {} x {} points\n", level, drawn.columns, drawn.rows));
  return {to_mesh_data(to_triangle_mesh(drawn)), to_mesh_data(mesh)};
}

void check_surface(const PyramidOptions& options, const PyramidHeader& header) {
  const bool by_normal = header.kind == PyramidKind::kReflectance;
  if (!by_normal && header.kind != PyramidKind::kColour)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: found a pyramid of {}, expected a pyramid of colours or reflected light", options.file,
                            pyramid_kind_name(header.kind)));
  if (by_normal && options.surface.mesh.empty() == options.surface_pyramid.empty())
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: a map over normals needs one surface, found {}, expected {}", options.file,
                            options.surface.mesh.empty() ? "none" : "two", "--mesh or --surface"));
  if (!by_normal && !(options.surface.mesh.empty() && options.surface_pyramid.empty()))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: a pyramid of colours is drawn on the plane; found {}, expected no surface",
                            options.file, options.surface.mesh.empty() ? "--surface" : "--mesh"));
  if (options.surface_pyramid.empty() && (options.detail.level || options.detail.spacing))
    throw Error(ErrorCode::kUsage, "--surface-level and --surface-spacing require --surface");
}

void write_pyramid_report(const PyramidOptions& options, const std::string& path, const nlohmann::json& facts) {
  nlohmann::json report = {{"software", std::string("multum-view ") + MULTUM_VERSION},
                           {"reference_samples", options.samples},
                           {"shifts", options.shifts},
                           {"anisotropy", options.anisotropy}};
  report.update(facts);
  write_text_file(path, json_text(report, 2) + "\n");
}

// Adds --lookup and --shifts.
void add_lookup_options(CLI::App& app, PyramidOptions& options) {
  app.add_option_function<std::string>(
         "--lookup", [&options](const std::string& text) { options.lookups = parse_lookups("--lookup", text); },
         "use these lookup methods: a list of nearest, bilinear (finest level), level (chosen by the longer side of a "
         "pixel), driver, and reference (supersampled)")
      ->default_str("level");
  app.add_option("--shifts", options.shifts,
                 "measure how much reflected light flickers, compared with the reference, over this many sub-pixel "
                 "shifts")
      ->check(CLI::Range(2, 256));
}

}  // namespace

void add_pyramid_options(CLI::App& app, PyramidOptions& options) {
  app.add_option("file", options.file,
                 "pyramid of `multum mip`, drawn on the plane, or of `multum reflectance`, drawn on --mesh")
      ->required();
  add_picture_option(app, options.output)->required();
  add_lookup_options(app, options);
  add_level_bias_option(
      app, options.level_bias,
      "add this to the level (default: 0 for colours; -0.79 for reflected light, which makes the blur one pixel wide)");
  app.add_option("--samples", options.samples, "draw the reference with this many samples per pixel")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  add_pictures_option(app, options.output);
  add_mesh_option(app, options.surface);
  app.add_option(
      "--surface", options.surface_pyramid,
      "draw reflected light on this surface pyramid (from `multum lod`). The surface is read at --surface-level, which "
      "limits its curvature; the reference always uses the finest level");
  add_surface_detail_options(app, options.detail);
  add_repeat_option(app, options.surface);
  add_camera_options(app, options.camera);
  app.add_option("--anisotropy", options.anisotropy, "set the anisotropy of the lookup method driver")
      ->check(number_in(1.0f, 16.0f))
      ->capture_default_str();
  add_output_options(app, options.output);
  add_context_option(app, options.context);
  add_decoding_option(app);
}

int draw_pyramid(const PyramidOptions& options) {
  const std::string& report = options.output.report;
  check_picture_path(options.output.path);
  check_paths_differ({options.file}, {options.output.path, report});
  if (options.shifts > 0 && options.lookups.front() != "reference")
    throw Error(ErrorCode::kUsage, "--shifts requires the reference: add reference to --lookup");
  const Pyramid pyramid = options.expected ? read_pyramid(options.file, *options.expected) : read_pyramid(options.file);
  check_surface(options, pyramid.header);
  std::optional<gl::PhongLights> lights;
  if (pyramid.header.kind == PyramidKind::kReflectance) lights = baked_lights(pyramid.header, options.file);
  ViewScenes scenes;
  const Surfaces surfaces = make_surfaces(options, pyramid.header, scenes);
  const std::unique_ptr<gl::HeadlessContext> context = gl::make_headless_context(options.context);
  log_info(context->description());
  PyramidPictures drawer(options, scenes.first, context->functions(), pyramid, surfaces, lights);
  std::vector<NamedPicture> pictures;
  for (const std::string& name : options.lookups) pictures.push_back({name, {drawer.draw(name, {0.0f, 0.0f}), 0.0}});
  const std::vector<double> flickers = options.shifts > 0 ? measure_flicker(options, drawer) : std::vector<double>();
  const nlohmann::json rows = print_rows(pictures, flickers);
  write_pictures(options.output, pictures);
  if (!report.empty())
    write_pyramid_report(options, report,
                         {{"context", context->description()},
                          {"pyramid", pyramid_kind_name(pyramid.header.kind)},
                          {"reference", lights ? "shaded at every sample" : "the finest level"},
                          {"level_bias", drawer.level_bias()},
                          {"pictures", rows}});
  return 0;
}

}  // namespace multum
