// SPDX-License-Identifier: Apache-2.0
// Reads and writes the results of texture inference, which are mip-mapped radiance textures and the manifest. For each
// point of the parameter space, the manifest lists the textures and places of the objects, and the camera.
// docs/reference/inferred_textures.md describes both.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/fields/inferred/texture_mapping.h"
#include "host/formats/asset/mip_layout.h"

namespace multum {

/// All levels of a texture. There are three colours per texel, in linear radiance and in the order of MipLayout.
struct InferredTexture {
  int width = 1, height = 1;
  std::vector<float> texels;
  std::string provenance;  // JSON: settings and inputs of the inference
};

/// Writes a tiled, mip-mapped EXR of 16-bit floats, with "multum:provenance" in its header. Values beyond the largest
/// 16-bit float become 65504. Writes a temporary file and renames it when it is complete. Throws Error(kEnvironment).
void write_inferred_texture(const InferredTexture& texture, const std::string& path);

/// Rounds values to those that a reader of the written file gets.
void round_to_half(std::vector<float>& values);

/// Throws Error(kInput), which names the file and its fault.
InferredTexture read_inferred_texture(const std::string& path);

/// Returns only the provenance. The provenance is empty if the file does not exist or is not an inferred texture.
std::string read_texture_provenance(const std::string& path);

struct InferredLayer {
  std::string name;
  std::vector<std::string> textures;  // texture of every sample, relative to the manifest; empty if the sample has none
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
  // The places of objects that differ from the geometry file.
  std::map<std::string, glm::dmat4> object_to_world;
};

struct InferredManifest {
  std::string geometry_file;  // relative to the manifest, or absolute
  std::string geometry_hash;  // SHA-256
  int uv_set = 0;
  int width = 0, height = 0;  // pixels
  int supersampling = 1;
  std::vector<std::string> parameters;
  std::vector<InferredSample> samples;
  std::vector<InferredObject> objects;  // includes objects without layers, because they hide objects behind them
};

constexpr const char* kInferredManifestName = "inferred.json";

void write_inferred_manifest(const InferredManifest& manifest, const std::string& path);
/// Throws Error(kInput), which names the file and its fault.
InferredManifest read_inferred_manifest(const std::string& path);

}  // namespace multum
