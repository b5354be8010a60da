// SPDX-License-Identifier: Apache-2.0
// Hammered copper: the lowest of many round dents, with a soft edge between neighbours.
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/formats/testmap/materials/periodic_noise.h"
#include "host/formats/testmap/materials/test_material.h"

namespace multum {
namespace {

constexpr int kDents = 18;           // per side
constexpr double kBowl = 0.34;       // slope at a distance of one cell from the middle of a dent
constexpr double kDepth = 0.16;      // largest difference of depths, in cells
constexpr double kSoftness = 0.018;  // width of the edge between two dents, in cells

class Hammered : public TestMaterial {
 public:
  explicit Hammered(std::uint64_t seed) : seed_(seed) {}

  MaterialPoint at(double u, double v) const override {
    // The smooth minimum -k log(sum exp(-h / k)), relative to the lowest dent.
    std::array<double, 9> heights{};
    std::size_t count = 0;
    for_near_points(u, v, kDents, seed_, [&](const glm::ivec2& cell, const glm::dvec2& away) {
      heights[count++] = 0.5 * kBowl * glm::dot(away, away) - kDepth * cell_random(cell.x, cell.y, 3, seed_);
    });
    const double least = *std::min_element(heights.begin(), heights.end());
    double sum = 0.0;
    for (const double height : heights) sum += std::exp((least - height) / kSoftness);
    MaterialPoint made;
    const double broad = fractal_noise(u, v, 3, 4, seed_ + 20), fine = fractal_noise(u, v, 64, 3, seed_ + 30);
    made.height = (least - kSoftness * std::log(sum) + 0.05 * broad) / kDents + 0.00002 * fine;
    const double patina = smooth_step(-0.1, 0.9, broad + 0.25 * fine);
    made.colour = glm::mix(glm::dvec3(0.93, 0.52, 0.36), glm::dvec3(0.55, 0.24, 0.15), patina);
    made.roughness = 0.2 + 0.16 * patina + 0.03 * fine;
    made.metalness = 1.0;
    return made;
  }

 private:
  const std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<TestMaterial> make_hammered(std::uint64_t seed) { return std::make_unique<Hammered>(seed); }

}  // namespace multum
