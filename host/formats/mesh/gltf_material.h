// SPDX-License-Identifier: Apache-2.0
// Reads a glTF file's materials, as far as a normal map's shading needs it (glTF 2.0, section 3.9): factors, normal
// textures, base colour textures, and the images themselves, which may lie inside the file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

struct GltfTexture {
  int image = 0;                                         // index into GltfMaterials::images
  int uv_set = 0;                                        // TEXCOORD_n
  std::string wrap_s = "periodic", wrap_t = "periodic";  // by the names of WrapMode
};

struct GltfMaterial {
  std::string name;  // unique: "material 2" where the file has none, "steel (2)" where it has two
  glm::vec4 base_colour{1.0f};
  float metallic = 1.0f;
  float roughness = 1.0f;
  float normal_scale = 1.0f;  // of the normal texture's x and y
  float anisotropy = 0.0f;    // strength, 0..1 (KHR_materials_anisotropy)
  std::optional<GltfTexture> normal;
  std::optional<GltfTexture> colour;              // base colour
  std::optional<GltfTexture> metallic_roughness;  // listed; not used
};

struct GltfImage {
  std::string name;       // of a file of its own, once extracted: "normal", "image_2"
  std::string file;       // path; empty: inside
  std::string extension;  // "png", "jpg", "webp", "ktx2": of embedded bytes
  std::string bytes;      // of an embedded image
};

struct GltfMaterials {
  std::vector<GltfMaterial> materials;  // in the file's order
  std::vector<GltfImage> images;
};

/// Throws Error(kInput) naming the file and what is wrong: not glTF or GLB, damaged, a texture that is not there, a
/// texture transform (KHR_texture_transform) that changes anything, an image format that cannot be read.
GltfMaterials read_gltf_materials(const std::string& path);

/// "Hull, front" as a name for a file: "Hull__front".
std::string safe_file_name(const std::string& name);

/// The image's file: its own, or `folder`/NAME.EXTENSION, written now. Throws Error(kEnvironment).
std::string extract_image(const GltfImage& image, const std::string& folder);

}  // namespace multum
