// SPDX-License-Identifier: Apache-2.0
// scene.toml: what a scene shows of its maps - which materials, lights and camera distances they meet - so that a bake
// can leave out what none of them needs. docs/reference/scenes.md describes every key.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/bakes/bake/bake_job.h"
#include "host/formats/brdf/brdf.h"

namespace multum {

struct SceneMap {
  std::string name;
  BakeJob job;  // what is read, and how; the rest is the plan's to say
};

struct SceneMaterial {
  std::string name;
  /// The same BRDF but for its width: one where it is fixed, the narrowest and the broadest where it changes at run
  /// time.
  std::vector<Brdf> brdfs;
  bool width_in_map = false;  // brdf = "roughness-map": each texel has its own
  std::string measured_file;  // of BrdfKind::kMeasured

  bool is_dynamic() const { return brdfs.size() > 1; }
};

struct SceneLight {
  bool is_point = false;
  glm::dvec3 place{0.0};  // towards a distant light, or where a point light is
  glm::dvec3 power{1.0};  // irradiance, or intensity
};

struct SceneObject {
  std::string name;
  std::size_t map = 0;
  std::vector<std::size_t> materials;             // several: basis BRDFs, a weight each
  double texels_per_metre = 0.0;                  // 0: as `width` says
  double width = 0.0;                             // metres that the map's width covers; 0: as `texels_per_metre` says
  double distance_min = 0.0, distance_max = 0.0;  // metres from the camera
  double tilt_max = 85.0;                         // degrees between the line of sight and the surface's normal
};

struct SceneCamera {
  double fov_degrees = 40.0;  // vertical
  int width = 1920, height = 1080;
};

struct SceneBudget {
  std::optional<double> bytes;         // of textures, all maps together
  std::optional<double> bake_ms;       // of the bake, by the model of docs/evidence/SCENE.md
  std::optional<double> target_error;  // relative L1 against the reference, each map's worst BRDF
  double estimate_margin = 0.02;       // by how much an estimated error may exceed the default bake's, relative L1
};

struct SceneDescription {
  SceneCamera camera;
  SceneBudget budget;
  std::vector<SceneMap> maps;
  std::vector<SceneMaterial> materials;
  std::vector<SceneObject> objects;
  std::vector<SceneLight> lights;
  std::string environment;  // a file over latitude and longitude; empty: none
};

/// Reads and validates; each map's job is `pattern` with what the scene says. Paths are against the scene's own folder.
/// Of other files measured BRDFs are read, and the rest must be there. Throws Error(kInput) that names the file, the
/// line, what was found and what was expected.
SceneDescription read_scene(const std::string& path, const BakeJob& pattern);

/// The files that a scene names. None of them is looked at. Throws as read_scene() does.
std::vector<std::string> scene_files(const std::string& path);

}  // namespace multum
