// SPDX-License-Identifier: Apache-2.0
// Small scenes for tests of texture inference: glTF text, EXR files of several layers, folders of renders, and where
// the real field lies.
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

/// One triangle, (0,0,0) (1,0,0) (0,1,0), with texture coordinates in set 0, and three times those in set 1.
struct GltfScene {
  std::string nodes = R"({"name":"thing","mesh":0})";  // the first is the root
  std::array<float, 9> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::array<float, 6> uvs = {0, 0, 1, 0, 0, 1};
  std::uint16_t last_index = 2;
};

std::string gltf_text(const GltfScene& scene);
/// A kilobyte that says it has 200 million corners, all but one of them zero.
std::string gltf_bomb();

/// One part of an EXR file: channels of float, and string attributes.
struct ExrPart {
  std::string name;
  std::vector<std::string> channels;
  std::vector<std::vector<float>> planes;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::string type = "float";
};

/// Fails the test when it cannot be written.
void write_exr(const std::string& path, int width, int height, const std::vector<ExrPart>& parts);

/// $MULTUM_SHARED_DATA/field_demo1, or empty when it is not there.
std::string shared_field();

/// The first camera of a folder's scene.json.
struct DemoCamera {
  glm::dmat4 world_to_camera, projection;
  int width, height;
  /// The point at a depth along -z of camera space behind the centre of a pixel; row 0 at the top.
  glm::dvec3 world_at(int x, int y, double depth) const;
};

DemoCamera demo_camera(const std::string& folder);

/// Writes a folder of renders as pack_field makes them: 4 x 3 pixels, 2 views and 2 positions of the other parameter,
/// one triangle "thing" at a distance of 2 that fills the picture. `moves`: the object moves, with object-index images.
void write_demo_folder(const std::string& folder, bool moves);

}  // namespace multum::testing
