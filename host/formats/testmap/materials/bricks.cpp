// SPDX-License-Identifier: Apache-2.0
// Bricks in running bond. Each brick has its own colour, depth and tilt, worn edges and pits. Mortar is sandy.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/formats/testmap/materials/periodic_noise.h"
#include "host/formats/testmap/materials/test_material.h"

namespace multum {
namespace {

constexpr int kColumns = 4, kRows = 12;  // the number of rows is even
constexpr double kJoint = 0.0055;        // half of the width of a joint
constexpr double kEdge = 0.012;          // width of the worn edge of a brick
constexpr double kRecess = 0.011;        // depth of the mortar

class Bricks : public TestMaterial {
 public:
  explicit Bricks(std::uint64_t seed) : seed_(seed) {}

  MaterialPoint at(double u, double v) const override {
    const double wobble = fractal_noise(u, v, 24, 3, seed_ + 70);
    const double up = v * kRows + 0.02 * gradient_noise(u, v, 8, seed_ + 71);
    const int row = wrapped_cell(static_cast<int>(std::floor(up)), kRows);
    const double along = u * kColumns + 0.5 * (row % 2) + 0.1 * (cell_random(row, 0, 5, seed_) - 0.5);
    const int column = wrapped_cell(static_cast<int>(std::floor(along)), kColumns);
    const glm::dvec2 inside(along - std::floor(along), up - std::floor(up));
    // The distance from the edges of the brick, in units of the square.
    const glm::dvec2 away = glm::min(inside, 1.0 - inside) / glm::dvec2(kColumns, kRows) - kJoint;
    const double edge = kEdge - glm::length(glm::max(glm::dvec2(kEdge) - away, 0.0)) + 0.0028 * wobble;
    const double is_brick = smooth_step(0.0, kEdge, edge);
    const auto own = [&](int axis) { return cell_random(column, row, axis, seed_); };

    const double rough = fractal_noise(u, v, 40, 5, seed_ + 80), sand = fractal_noise(u, v, 150, 3, seed_ + 90);
    const double pits = pits_at(u, v);
    const double tilt = 0.01 * (own(7) - 0.5) * (inside.x - 0.5) + 0.018 * (own(8) - 0.5) * (inside.y - 0.5);
    const double face = kRecess * (0.75 + 0.35 * own(6)) + tilt + 0.0011 * rough - 0.004 * pits;
    const double mortar = 0.0008 * rough + 0.0011 * sand;
    MaterialPoint made;
    made.height = glm::mix(mortar, face, is_brick);
    const double burnt = smooth_step(0.7, 1.0, own(9));
    glm::dvec3 brick = glm::mix(glm::dvec3(0.27, 0.065, 0.035), glm::dvec3(0.36, 0.14, 0.07), own(10));
    brick = glm::mix(brick, glm::dvec3(0.1, 0.05, 0.045), 0.8 * burnt) * (1.0 + 0.28 * rough - 0.4 * pits);
    const glm::dvec3 grey = glm::dvec3(0.36, 0.33, 0.29) * (1.0 + 0.2 * sand + 0.15 * rough);
    made.colour = glm::clamp(glm::mix(grey, brick, is_brick), 0.0, 1.0);
    made.roughness = std::clamp(glm::mix(0.92, 0.62 - 0.22 * burnt + 0.08 * rough + 0.2 * pits, is_brick), 0.0, 1.0);
    return made;
  }

 private:
  // Returns the depth of round holes in a few cells, 0 to 1.
  double pits_at(double u, double v) const {
    constexpr double kSmooth = 0.72;  // share of cells without a pit
    double deepest = 0.0;
    for_near_points(u, v, 44, seed_ + 100, [&](const glm::ivec2& cell, const glm::dvec2& away) {
      const double size = cell_random(cell.x, cell.y, 11, seed_);
      if (size < kSmooth) return;
      deepest = std::max(deepest, 1.0 - smooth_step(0.05, 0.1 + 0.5 * (size - kSmooth), glm::length(away)));
    });
    return deepest;
  }

  const std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<TestMaterial> make_bricks(std::uint64_t seed) { return std::make_unique<Bricks>(seed); }

}  // namespace multum
