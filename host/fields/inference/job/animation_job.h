// SPDX-License-Identifier: Apache-2.0
// Describes a job of texture inference (Hakura et al. 2000, section 3). A job has the renders, their geometry, cameras
// and parameters, and the textures to infer. docs/reference/animation_jobs.md describes every key of animation.toml.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

namespace multum {

/// One dimension of the parameter space, such as "view" or "light".
struct AnimationParameter {
  std::string name;
  int count = 1;         // number of samples along this dimension
  bool is_view = false;  // moves the camera
  int block = 0;         // number of neighbouring samples that share texture coordinates, if the parameter moves
                         // anything; 0 means all
  bool operator==(const AnimationParameter&) const = default;
};

/// A part of the radiance that gets its own textures. The part "diffuse" comes from the diffuse pass, and
/// "view_dependent" comes from the sum of the glossy and transmission passes.
struct AnimationLayer {
  std::string name;
  std::vector<std::string> passes;  // prefixes of channels "PASS.R" "PASS.G" "PASS.B"; "" means the channels R G B
  // The names of parameters. One texture serves all samples along the other parameters.
  std::vector<std::string> depends_on;
  bool operator==(const AnimationLayer&) const = default;
};

/// The texture settings of an object. Default values come from the job's [texture] table, or from this struct if there
/// is no such table.
struct AnimationTexture {
  std::string wrap = "clamp";     // "clamp" or "periodic"; in periodic directions a branch cut is tried
  double stretch_max = 1.25;      // largest singular value of the texture-to-screen Jacobian, > 0
  double resolution_scale = 1.0;  // (0, 8]; factor of each side, applied after the stretch limit
  bool power_of_two = false;      // rounds each side up to a power of two
  int side_max = 2048;            // texels, 1..16384
  double anisotropy = 1.0;        // 1..16, anisotropy of the sampler
  double pyramid_weight = 0.1;    // epsilon_f of pyramidal regularization, >= 0
  double range_weight = 0.0;      // epsilon_b of range regularization, >= 0; with 0, only the bounds limit texels
  bool operator==(const AnimationTexture&) const = default;
};

struct AnimationObject {
  std::string name;                 // name of the object and of its textures' folder
  std::string mesh;                 // object of the geometry file
  std::string cryptomatte;          // name in the Cryptomatte manifest; if empty, `index` is used
  int index = 0;                    // number in object-index images, from 1; 0 if it has none
  std::vector<std::string> layers;  // empty means all; layers in which the object is black are always left out
  AnimationTexture texture;
  bool operator==(const AnimationObject&) const = default;
};

struct AnimationCamera {
  std::string name;
  glm::dmat4 world_to_camera{1.0};  // right-handed, looks along -z
  glm::dmat4 projection{1.0};       // maps to OpenGL clip space: -w..w, y up
  bool operator==(const AnimationCamera&) const = default;
};

struct AnimationSample {
  std::vector<int> at;       // index along each parameter
  std::string name;          // "v00_p03"
  std::string radiance;      // resolved path of the EXR with the layers' passes
  std::string geometry;      // EXR with depth and Cryptomatte; may be the radiance file; empty only if
                             // object_index is given
  std::string object_index;  // PNG whose grey value is the object's number; if empty, Cryptomatte is used
  int camera = 0;
  std::map<std::string, glm::dmat4> object_to_world;  // transforms of moving objects, by mesh name
  bool operator==(const AnimationSample&) const = default;
};

struct AnimationJob {
  std::string path;  // the job file; relative paths in the job are relative to this file's folder
  std::string geometry_file;
  int uv_set = 0;
  int width = 0, height = 0;                 // pixels
  std::string cryptomatte = "CryptoObject";  // prefix of its channels
  std::string depth = "Z";         // channel with the distance along -z of camera space at the pixel centre; empty if
                                   // there is none
  double depth_tolerance = 0.01;   // largest allowed deviation of depth from the geometry, relative to the depth
  int supersampling = 4;           // 1..8 sub-pixels along a pixel's side, in matrix A and in rendered frames
  double radiance_max = 1.0;       // > 0: brighter values are clipped to this value and counted
  double coverage_min = 1.0 / 64;  // pixels with less coverage by an object are left out
  std::vector<AnimationParameter> parameters;
  std::vector<AnimationLayer> layers;
  std::vector<AnimationObject> objects;
  std::vector<AnimationCamera> cameras;
  std::vector<AnimationSample> samples;  // one for each point of the parameter grid; the last parameter changes fastest
  bool operator==(const AnimationJob&) const = default;
};

/// Returns the job as TOML for read_animation_job(). Paths are written relative to `folder`.
std::string animation_job_text(const AnimationJob& job, const std::string& folder);

/// Makes a job for a folder of renders. The folder has scene.json with rad_vVV_pPP.exr and geom_vVV.exr, or
/// id_vVV_pPP.png if objects move (docs/reference/animation_jobs.md, "Supported folders"). Throws Error(kInput), which
/// lists the expected files.
AnimationJob job_for_folder(const std::string& folder);

}  // namespace multum
