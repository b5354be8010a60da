// SPDX-License-Identifier: Apache-2.0
// Reads scene.toml, which describes the materials, lights and camera distances with which a scene shows its maps. A
// bake can then omit data that the scene does not need. docs/reference/scenes.md describes every key.
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
  BakeJob job;  // inputs of the map's bake; the plan decides the other settings
};

struct SceneMaterial {
  std::string name;
  /// One BRDF if its width is fixed, or the narrowest and the broadest BRDF if the width changes at run time.
  std::vector<Brdf> brdfs;
  bool width_in_map = false;  // true for brdf = "roughness-map": each texel has its own width
  std::string measured_file;  // file of a BRDF of BrdfKind::kMeasured

  bool is_dynamic() const { return brdfs.size() > 1; }
};

struct SceneLight {
  bool is_point = false;
  glm::dvec3 place{0.0};  // direction to a distant light, or position of a point light
  glm::dvec3 power{1.0};  // irradiance of a distant light, or intensity of a point light
};

struct SceneObject {
  std::string name;
  std::size_t map = 0;
  std::vector<std::size_t> materials;             // several materials are basis BRDFs, each with a weight
  double texels_per_metre = 0.0;                  // 0 if `width` is given
  double width = 0.0;                             // metres that the map's width covers; 0 if texels_per_metre is given
  double distance_min = 0.0, distance_max = 0.0;  // metres from the camera
  double tilt_max = 85.0;                         // degrees between the line of sight and the surface's normal
};

struct SceneCamera {
  double fov_degrees = 40.0;  // vertical field of view
  int width = 1920, height = 1080;
};

struct SceneBudget {
  std::optional<double> bytes;         // bytes of the textures of all maps together
  std::optional<double> bake_ms;       // time of the bake by the model of docs/evidence/SCENE.md
  std::optional<double> target_error;  // relative L1 error against the reference, for the worst BRDF of each map
  double estimate_margin = 0.02;       // the amount by which the estimated relative L1 error may exceed the error of
                                       // the default bake
};

struct SceneDescription {
  SceneCamera camera;
  SceneBudget budget;
  std::vector<SceneMap> maps;
  std::vector<SceneMaterial> materials;
  std::vector<SceneObject> objects;
  std::vector<SceneLight> lights;
  std::string environment;  // latitude-longitude image; empty if there is none
};

/// Reads and validates a scene. Each map's job is `pattern` with the scene's values. Paths are relative to the scene's
/// folder. The files of measured BRDFs are read. Other files must exist, but are not read. Throws Error(kInput) that
/// names the file, the line, the value found and the value expected.
SceneDescription read_scene(const std::string& path, const BakeJob& pattern);

/// Lists the files that a scene names, and reads none of them. Throws the same errors as read_scene().
std::vector<std::string> scene_files(const std::string& path);

}  // namespace multum
