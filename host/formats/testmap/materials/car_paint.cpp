// SPDX-License-Identifier: Apache-2.0
// Car paint: flakes of metal, each with its own tilt and tint, on a surface that is slightly wavy.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/formats/testmap/materials/periodic_noise.h"
#include "host/formats/testmap/materials/test_material.h"

namespace multum {
namespace {

constexpr int kFlakes = 170;       // per side
constexpr double kTilt = 0.13;     // mean slope of flakes
constexpr double kTiltMost = 0.9;  // largest slope

class CarPaint : public TestMaterial {
 public:
  explicit CarPaint(std::uint64_t seed) : seed_(seed) {}

  MaterialPoint at(double u, double v) const override {
    double nearest = 1e9;
    glm::ivec2 flake(0);
    for_near_points(u, v, kFlakes, seed_, [&](const glm::ivec2& cell, const glm::dvec2& away) {
      // Flakes have different sizes.
      const double distance = glm::length(away) - 0.35 * cell_random(cell.x, cell.y, 12, seed_);
      if (distance < nearest) nearest = distance, flake = cell;
    });
    const auto own = [&](int axis) { return cell_random(flake.x, flake.y, axis, seed_); };
    const double slope = std::min(kTiltMost, -kTilt * std::log(1.0 - own(13)));
    const double turn = kWholeTurn * own(14);
    MaterialPoint made;
    made.slope = slope * glm::dvec2(std::cos(turn), std::sin(turn));
    made.height = 0.00035 * fractal_noise(u, v, 12, 2, seed_ + 110);
    const glm::dvec3 deep(0.012, 0.045, 0.3), bright(0.06, 0.28, 0.75), violet(0.2, 0.07, 0.5);
    made.colour = glm::mix(glm::mix(deep, bright, own(15)), violet, smooth_step(0.75, 1.0, own(16)));
    made.roughness = 0.22 + 0.12 * own(17);
    made.metalness = 1.0;
    return made;
  }

 private:
  const std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<TestMaterial> make_car_paint(std::uint64_t seed) { return std::make_unique<CarPaint>(seed); }

}  // namespace multum
