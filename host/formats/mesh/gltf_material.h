// SPDX-License-Identifier: Apache-2.0
// Reads the part of the materials of a glTF file that shading with a normal map needs (glTF 2.0, section 3.9). This
// part consists of factors, normal textures, base colour textures, and images, which may be embedded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace multum {

struct GltfTexture {
  int image = 0;                                         // index into GltfMaterials::images
  int uv_set = 0;                                        // n of TEXCOORD_n
  std::string wrap_s = "periodic", wrap_t = "periodic";  // names of WrapMode
};

struct GltfMaterial {
  std::string name;  // unique name; a missing name becomes "material 2", and a repeated one "steel (2)"
  glm::vec4 base_colour{1.0f};
  float metallic = 1.0f;
  float roughness = 1.0f;
  float normal_scale = 1.0f;  // scale of the normal texture's x and y
  float anisotropy = 0.0f;    // strength, 0..1 (KHR_materials_anisotropy)
  std::optional<GltfTexture> normal;
  std::optional<GltfTexture> colour;              // base colour
  std::optional<GltfTexture> metallic_roughness;  // listed, but not used
};

struct GltfImage {
  std::string name;       // name of the extracted file: "normal", "image_2"
  std::string file;       // path; empty for an embedded image
  std::string extension;  // format of embedded bytes: "png", "jpg", "webp" or "ktx2"
  std::string bytes;      // bytes of an embedded image
};

struct GltfMaterials {
  std::vector<GltfMaterial> materials;  // in the file's order
  std::vector<GltfImage> images;
};

/// Reads the materials. Throws Error(kInput), which names the file and the fault. The faults are a file that is damaged
/// or is not glTF or GLB, a missing texture, a texture transform that has an effect (KHR_texture_transform), and an
/// image format that cannot be read.
GltfMaterials read_gltf_materials(const std::string& path);

/// Turns a name into a safe file name: "Hull, front" becomes "Hull__front".
std::string safe_file_name(const std::string& name);

/// Returns the path of the image. An embedded image is first written to `folder`/NAME.EXTENSION. Throws
/// Error(kEnvironment).
std::string extract_image(const GltfImage& image, const std::string& folder);

}  // namespace multum
