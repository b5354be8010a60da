// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_scenes.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <utility>

#include "host/formats/brdf/brdf_text.h"
#include "host/foundation/base/error.h"
#include "runtime_gl/render/camera.h"

namespace multum {
namespace {

bool looks_along(const gl::Camera& camera, const glm::vec3& direction) {
  const glm::vec3 view = camera.target - camera.eye;
  return glm::length(glm::cross(view, direction)) < 1e-4f * glm::length(view) * glm::length(direction);
}

void place_camera(const CameraPlace& place, gl::Camera& camera) {
  camera.eye = place.eye;
  camera.target = place.target;
  if (place.fov_y_degrees) camera.fov_y_degrees = *place.fov_y_degrees;
}

/// Sets the up direction, which is +Y for meshes, as in glTF, and +Z for the plane.
void set_up(const PictureOptions& options, ViewScenes& scenes) {
  gl::Camera& camera = scenes.first.camera;
  const bool is_plane = options.surface.mesh.empty();
  scenes.up = options.camera.up.value_or(is_plane ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f));
  if (options.camera.up && (scenes.has_camera || is_plane) && looks_along(camera, scenes.up))
    throw Error(ErrorCode::kUsage, "--up is parallel to the line of sight, expected another direction, such as 0,0,1");
  // A camera that looks straight up or down needs another up direction. It is +Y for the plane and -Z for a mesh.
  if (!options.camera.up && scenes.has_camera && looks_along(camera, scenes.up))
    scenes.up = is_plane ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
  camera.up = scenes.up;
}

void set_lights(const LightOptions& options, const glm::vec3& up, gl::RenderScene& scene) {
  if (options.distant.size() > gl::kLightCountMax)
    throw Error(ErrorCode::kUsage, "--light: found more than 8 lights, expected at most 8");
  if (options.points.size() > gl::kLightCountMax)
    throw Error(ErrorCode::kUsage, "--point-light: found more than 8 lights, expected at most 8");
  if (!options.distant.empty() || !options.points.empty() || !options.environment.empty())
    scene.lights = options.distant;
  scene.point_lights = options.points;
  scene.environment_mode = options.environment_mode.value_or(gl::EnvironmentMode::kPrefiltered);
  scene.environment_up = up;
  scene.environment_turn = options.environment_turn.value_or(0.0f);
}

void check_under_environment(const std::string& option, const Brdf& brdf) {
  const std::string refusal = environment_refusal(brdf);
  if (!refusal.empty()) throw Error(ErrorCode::kUsage, option + ": " + refusal);
}

std::vector<Brdf> make_basis(const MaterialOptions& options, bool has_environment) {
  if (options.brdfs.size() > kWeightCountMax)
    throw Error(ErrorCode::kUsage, "--brdf: found more than 4, expected at most 4, one per weight");
  const std::vector<std::string> brdfs =
      options.brdfs.empty() ? std::vector<std::string>{"blinn-phong:100"} : options.brdfs;
  for (const auto& [option, colours] :
       {std::pair{"--diffuse", &options.diffuse}, std::pair{"--specular", &options.specular}})
    if (colours->size() > 1 && colours->size() != brdfs.size())
      throw Error(ErrorCode::kUsage, fmt::format("{}: found {}, expected one, or one for each of the {} --brdf options",
                                                 option, colours->size(), brdfs.size()));
  std::vector<Brdf> basis;
  for (std::size_t k = 0; k < brdfs.size(); ++k) {
    Brdf brdf = parse_brdf("--brdf", brdfs[k], options.term_count);
    const auto of_this = [&](const std::vector<glm::vec3>& colours) { return colours[colours.size() > 1 ? k : 0]; };
    if (!options.diffuse.empty()) brdf.diffuse = of_this(options.diffuse);
    if (!options.specular.empty()) brdf.specular = of_this(options.specular);
    if (has_environment) check_under_environment("--brdf", brdf);
    if (options.fixed_fresnel) brdf.fixed_fresnel = *options.fixed_fresnel;
    basis.push_back(brdf);
  }
  return basis;
}

void change_brdf(const AnimationOptions& options, const ViewScenes& scenes, Brdf& brdf) {
  if (scenes.basis.size() > 1 && (!options.brdf.empty() || options.diffuse || options.specular))
    throw Error(ErrorCode::kUsage, "--to-brdf, --to-diffuse and --to-specular: found several --brdf, expected one");
  if (!options.brdf.empty()) {
    const Brdf before = brdf;
    brdf = parse_brdf("--to-brdf", options.brdf, before.term_count);
    if (brdf.kind != before.kind || brdf.kind == BrdfKind::kMeasured)
      refuse_value("--to-brdf", options.brdf, "another parameter of the same BRDF family as --brdf");
    brdf.diffuse = before.diffuse;
    brdf.specular = before.specular;
  }
  if (options.diffuse) brdf.diffuse = *options.diffuse;
  if (options.specular) brdf.specular = *options.specular;
}

template <typename Light>
void change_lights(const char* option, const std::vector<Light>& changed, std::vector<Light>& lights) {
  if (changed.empty()) return;
  if (changed.size() != lights.size())
    throw Error(ErrorCode::kUsage, fmt::format("{}: found {} lights, expected the {} of the first frame", option,
                                               changed.size(), lights.size()));
  lights = changed;
}

}  // namespace

ViewScenes make_scenes(const PictureOptions& options) {
  ViewScenes scenes;
  scenes.has_camera = options.camera.place.has_value();
  if (options.camera.place) place_camera(*options.camera.place, scenes.first.camera);
  set_up(options, scenes);
  set_lights(options.light, scenes.up, scenes.first);
  scenes.basis = make_basis(options.material, !options.light.environment.empty());
  scenes.first.brdf = scenes.basis[0];
  scenes.first.filter = options.shading.filter;
  scenes.first.filter.evaluations =
      options.shading.filter.shades_taps ? 0 : options.shading.evaluations.value_or(gl::kEvaluationsOfLobes);
  scenes.first.filter.is_turned = !options.surface.mesh.empty();
  scenes.first.filter.level_bias = options.shading.level_bias.value_or(static_cast<float>(kLevelBiasDefault));
  if (options.material.fixed_fresnel && !options.light.environment.empty())
    throw Error(ErrorCode::kUsage, "--fixed-fresnel works only with lights; found --environment, expected none");
  if (options.shading.formula == gl::LobeFormula::kPaper && scenes.first.brdf.kind != BrdfKind::kBlinnPhong)
    throw Error(ErrorCode::kUsage, "--formula paper works only with Blinn-Phong, expected --brdf blinn-phong:S");
  scenes.last = scenes.first;
  return scenes;
}

void change_last_scene(const AnimationOptions& options, ViewScenes& scenes) {
  scenes.has_last_camera = options.camera.has_value();
  if (options.camera) place_camera(*options.camera, scenes.last.camera);
  if (options.environment_turn) scenes.last.environment_turn = *options.environment_turn;
  change_brdf(options, scenes, scenes.last.brdf);
  change_lights("--to-light", options.lights, scenes.last.lights);
  change_lights("--to-point-light", options.point_lights, scenes.last.point_lights);
}

std::vector<View> views_of(const PictureOptions& options, const gl::RenderScene& scene) {
  if (options.camera.distances.empty()) return {{options.output, scene, std::nullopt}};
  std::vector<View> views;
  const std::string& path = options.output.path;
  const std::size_t ending = path.rfind('.');
  for (const float factor : options.camera.distances) {
    View& view = views.emplace_back(View{options.output, scene, factor});
    view.output.path = fmt::format("{}_{:g}{}", path.substr(0, ending), factor, path.substr(ending));
    if (!view.output.pictures.empty()) view.output.pictures += fmt::format("_{:g}", factor);
    view.scene.camera = gl::moved_away(scene.camera, factor);
  }
  return views;
}

}  // namespace multum
