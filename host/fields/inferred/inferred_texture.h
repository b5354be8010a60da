// SPDX-License-Identifier: Apache-2.0
// Reads and writes the results of texture inference: mip-mapped textures of radiance, and the manifest that says which
// of them an object has at each point of the parameter space, where it is then, and from where it is seen.
// docs/reference/inferred_textures.md describes both.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/asset/mip_layout.h"

namespace multum {

/// Every level of a texture: three colours a texel, linear radiance, MipLayout's order.
struct InferredTexture {
  int width = 1, height = 1;
  std::vector<float> texels;
  std::string provenance;  // JSON: how it was inferred, and from what
};

/// A tiled, mip-mapped EXR of halfs, "multum:provenance" in its header; values beyond the largest half become that
/// one, 65504. Appears whole, by rename. Throws Error(kEnvironment).
void write_inferred_texture(const InferredTexture& texture, const std::string& path);

/// Rounds values to what the file gives back of them.
void round_to_half(std::vector<float>& values);

/// Throws Error(kInput) naming the file and what is wrong with it.
InferredTexture read_inferred_texture(const std::string& path);

/// The provenance alone; empty when there is no such file, or no such texture in it.
std::string read_texture_provenance(const std::string& path);

struct InferredLayer {
  std::string name;
  std::vector<std::string> textures;  // of every sample, relative to the manifest; empty: the object has none there
};

struct InferredObject {
  std::string name;
  std::string mesh;  // object of the geometry file
  std::vector<TextureMapping> mappings;
  std::vector<int> mapping_of_sample;  // index into mappings, for each sample
  float anisotropy = 1.0f;
  std::vector<InferredLayer> layers;
};

struct InferredSample {
  std::string name;
  std::vector<int> at;  // index along each parameter
  glm::dmat4 world_to_clip{1.0};
  std::map<std::string, glm::dmat4> object_to_world;  // of objects that are not where the geometry file has them
};

struct InferredManifest {
  std::string geometry_file;  // relative to the manifest, or absolute
  std::string geometry_hash;  // SHA-256
  int uv_set = 0;
  int width = 0, height = 0;  // pixels
  int supersampling = 1;
  std::vector<std::string> parameters;
  std::vector<InferredSample> samples;
  std::vector<InferredObject> objects;  // also those without layers: they hide what is behind
};

constexpr const char* kInferredManifestName = "inferred.json";

void write_inferred_manifest(const InferredManifest& manifest, const std::string& path);
/// Throws Error(kInput) naming the file and what is wrong.
InferredManifest read_inferred_manifest(const std::string& path);

}  // namespace multum
