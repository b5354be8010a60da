// SPDX-License-Identifier: Apache-2.0
// Makes small scenes for tests of texture inference: glTF text, EXR files with several layers, and folders of renders.
// Also finds the real field.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace multum::testing {

/// Describes one triangle, (0,0,0) (1,0,0) (0,1,0). Set 0 of the texture coordinates equals the positions; set 1 is
/// three times set 0.
struct GltfScene {
  std::string nodes = R"({"name":"thing","mesh":0})";  // the first is the root
  std::array<float, 9> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::array<float, 6> uvs = {0, 0, 1, 0, 0, 1};
  std::uint16_t last_index = 2;
};

std::string gltf_text(const GltfScene& scene);
/// Returns a kilobyte of glTF that claims to have 200 million corners, all of which except one are zero.
std::string gltf_bomb();

/// Describes one part of an EXR file: float channels and string attributes.
struct ExrPart {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::vector<float>> planes;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string type = "float";
};

/// Writes the file. Fails the test if the file cannot be written.
void write_exr(const std::string& path, int width, int height, const std::vector<ExrPart>& parts);

/// Returns $MULTUM_SHARED_DATA/field_demo1, or "" if it does not exist.
std::string shared_field();

/// Holds the first camera of a folder's scene.json.
struct DemoCamera {
  glm::dmat4 world_to_camera, projection;
  int width, height;
  /// Returns the point that the centre of a pixel shows at `depth`, along -z of camera space. Row 0 is at the top.
  glm::dvec3 world_at(int x, int y, double depth) const;
};

DemoCamera demo_camera(const std::string& folder);

/// Writes a folder of renders like pack_field, with 4 x 3 pixels, 2 views, and 2 positions of the other parameter. A
/// triangle named "thing" at a distance of 2 fills the picture. With `moves`, the object moves, and there are
/// object-index images.
void write_demo_folder(const std::string& folder, bool moves);

}  // namespace multum::testing
