// SPDX-License-Identifier: Apache-2.0
// Bakes the reflection of distant lights into a mip-mapped map that is indexed by the surface normal, for a surface
// with one Blinn-Phong BRDF and a distant viewer (Williams 1983, section 4). Uses kernels/reflectance_pyramid.cl and
// kernels/mip_box.cl.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/pyramid/mip_bake.h"
#include "host/formats/asset/pyramid/reflectance_mapping.h"
#include "host/formats/light/environment_map.h"

namespace multum {

struct ReflectanceLight {
  glm::dvec3 direction{0.0, 0.0, 1.0};  // towards the light, in world space, any length > 0
  glm::dvec3 irradiance{3.141592653589793};
};

struct ReflectanceJob {
  std::vector<ReflectanceLight> lights;
  std::string environment;         // latitude-longitude image; empty if there is none
  float environment_scale = 1.0f;  // factor for the environment's radiance
  glm::dvec3 viewer{0.0, 0.0, 1.0};
  glm::dvec3 up{0.0, 1.0, 0.0};
  float exponent = 100.0f;  // s, 1..1e5
  glm::dvec3 diffuse{0.5};
  glm::dvec3 specular{0.1};
  int size = 512;       // texels per side, 4..8192
  int sample_side = 2;  // normals per side of a texel, 1..16
  std::string output;
  std::string report;
  StorageEncoding encoding = StorageEncoding::kHalf;
  BakedWriteOptions writing;
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;
  int threads = 1;
  bool force = false;
};

/// Throws Error(kUsage) for values out of range, or if there is no light.
void validate(const ReflectanceJob& job);

/// Makes lights for the cells of a latitude-longitude environment. The number of cells depends on the BRDF's lobe. A
/// cell is about half as wide as the lobe, which is 1 / (2 sqrt(s)) radians. Directions are those of EnvironmentMap,
/// with +Y up and -Z in the middle.
std::vector<ReflectanceLight> environment_lights(const EnvironmentMap& environment, float exponent, float scale);

/// Throws Error and Cancelled. Leaves no partial file.
MipReport bake_reflectance(const ReflectanceJob& job, Device& device, Progress* progress);

/// Makes the pyramid in memory without rounding, from the job's lights only.
Pyramid reflectance_pyramid(const ReflectanceJob& job, Device& device);

}  // namespace multum
