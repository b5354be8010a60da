// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/animated_view.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <glm/common.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum_view/view_outputs.h"

namespace multum {
namespace {

// Interpolates geometrically, so that a highlight narrows at a steady rate.
float between(float from, float to, double t) {
  return static_cast<float>(
      std::exp((1.0 - t) * std::log(static_cast<double>(from)) + t * std::log(static_cast<double>(to))));
}

Brdf brdf_between(const Brdf& from, const Brdf& to, double t) {
  const auto share = static_cast<float>(t);
  Brdf brdf = from;
  for (float Brdf::*const number : kBrdfNumbers) brdf.*number = between(from.*number, to.*number, t);
  brdf.f0 = glm::mix(from.f0, to.f0, share);
  brdf.diffuse = glm::mix(from.diffuse, to.diffuse, share);
  brdf.specular = glm::mix(from.specular, to.specular, share);
  return brdf;
}

}  // namespace

gl::RenderScene scene_between(const gl::RenderScene& from, const gl::RenderScene& to, double t) {
  const auto share = static_cast<float>(t);
  gl::RenderScene scene = from;
  scene.camera.eye = glm::mix(from.camera.eye, to.camera.eye, share);
  scene.camera.target = glm::mix(from.camera.target, to.camera.target, share);
  scene.camera.fov_y_degrees = glm::mix(from.camera.fov_y_degrees, to.camera.fov_y_degrees, share);
  scene.environment = mix_environments(from.environment, to.environment, t);
  scene.environment_turn = glm::mix(from.environment_turn, to.environment_turn, share);
  scene.brdf = brdf_between(from.brdf, to.brdf, t);
  MULTUM_CHECK(from.lights.size() == to.lights.size() && from.point_lights.size() == to.point_lights.size());
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    // The directions may have any length. The mix moves along the arc between them at a nearly constant speed.
    scene.lights[i].direction =
        glm::mix(glm::normalize(from.lights[i].direction), glm::normalize(to.lights[i].direction), share);
    scene.lights[i].irradiance = glm::mix(from.lights[i].irradiance, to.lights[i].irradiance, share);
  }
  for (std::size_t i = 0; i < scene.point_lights.size(); ++i) {
    scene.point_lights[i].position = glm::mix(from.point_lights[i].position, to.point_lights[i].position, share);
    scene.point_lights[i].intensity = glm::mix(from.point_lights[i].intensity, to.point_lights[i].intensity, share);
  }
  return scene;
}

std::string frame_path(const AnimationOptions& options, int frame) {
  return (std::filesystem::path(options.folder) / fmt::format("frame_{:04}.png", frame)).string();
}

nlohmann::json draw_animation(const MapOptions& options, const ViewScenes& scenes, PictureDrawer& drawer) {
  nlohmann::json frames = nlohmann::json::array();
  const int count = options.animation.frame_count;
  OutputOptions output = options.picture.output;
  for (int frame = 0; frame < count; ++frame) {
    const double t = count > 1 ? static_cast<double>(frame) / (count - 1) : 0.0;
    output.path = frame_path(options.animation, frame);
    write_shown(stdout, fmt::format("frame {}\n", frame));
    const gl::RenderScene scene = scene_between(scenes.first, scenes.last, t);
    const std::vector<NamedPicture> pictures = drawer.draw(scene);
    frames.push_back(print_table(pictures));
    if (scene.environment)
      frames.back()[0]["environment_processor_ms"] = {{"made", 1e3 * scene.environment->processor_seconds},
                                                      {"set", 1e3 * drawer.take_environment_seconds()}};
    write_pictures(output, pictures);
  }
  return frames;
}

}  // namespace multum
