// SPDX-License-Identifier: Apache-2.0
// Describes a request to the OpenGL runtime to measure filter matrices of objects in one view. `multum-view probe`
// reads it as a JSON file (docs/reference/inferred_textures.md).
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/inferred/texture_mapping.h"

namespace multum {

struct ProbeTask {
  std::string object;  // object of the geometry file
  TextureMapping mapping;
  float anisotropy = 1.0f;
  bool has_mips = true;
  std::string output;  // the matrix's file
  std::string key;     // set by the requester, stored in the matrix's provenance
};

struct ProbeRequest {
  std::string geometry_file;
  int uv_set = 0;
  int width = 0, height = 0;  // pixels
  int supersampling = 1;
  std::string view;
  glm::dmat4 world_to_clip{1.0};
  // The places of objects that differ from the geometry file.
  std::map<std::string, glm::dmat4> object_to_world;
  std::vector<ProbeTask> tasks;
};

void write_probe_request(const ProbeRequest& request, const std::string& path);
/// Throws Error(kInput), which names the file and its fault.
ProbeRequest read_probe_request(const std::string& path);

}  // namespace multum
