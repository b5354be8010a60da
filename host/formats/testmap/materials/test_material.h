// SPDX-License-Identifier: Apache-2.0
// Makes materials that look real and need no files: hammered copper, denim, bricks, car paint and water. They repeat in
// both directions. One square is about a metre wide, except for denim and car paint, which would be much smaller.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/foundation/base/choices.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

enum class MaterialKind { kHammered, kDenim, kBricks, kCarPaint, kWater };
inline constexpr Choices<MaterialKind> kMaterialKinds = {{"hammered", MaterialKind::kHammered},
                                                         {"denim", MaterialKind::kDenim},
                                                         {"bricks", MaterialKind::kBricks},
                                                         {"car-paint", MaterialKind::kCarPaint},
                                                         {"water", MaterialKind::kWater}};

/// A point of a material.
struct MaterialPoint {
  double height = 0.0;     // in units of the square's side
  glm::dvec2 slope{0.0};   // added to the slopes of the heights; x grows to the right, y upwards
  glm::dvec3 colour{0.5};  // base colour, linear, 0..1
  double roughness = 0.5;  // perceptual, 0..1
  double metalness = 0.0;  // 0..1
};

class TestMaterial {
 public:
  virtual ~TestMaterial() = default;
  /// `u` grows to the right and `v` downwards. Both have the period 1.
  virtual MaterialPoint at(double u, double v) const = 0;
};

std::unique_ptr<TestMaterial> make_hammered(std::uint64_t seed);
std::unique_ptr<TestMaterial> make_denim(std::uint64_t seed);
std::unique_ptr<TestMaterial> make_bricks(std::uint64_t seed);
std::unique_ptr<TestMaterial> make_car_paint(std::uint64_t seed);
std::unique_ptr<TestMaterial> make_water(std::uint64_t seed);

std::unique_ptr<TestMaterial> make_material(MaterialKind kind, std::uint64_t seed);

/// Writes PREFIX_normal.png (16 bits), PREFIX_albedo.png (16 bits, sRGB) and PREFIX_orm.png (16 bits; occlusion is 1,
/// then roughness and metalness) of `size` x `size` texels. Writes all files atomically and row by row. Throws
/// Error(kEnvironment).
void write_material(MaterialKind kind, int size, std::uint64_t seed, const std::string& prefix, GreenAxis green);

}  // namespace multum
