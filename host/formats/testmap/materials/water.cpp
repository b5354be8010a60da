// SPDX-License-Identifier: Apache-2.0
// Water: waves with sharp crests in many directions around the wind. Longer waves are higher.
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <vector>

#include "host/formats/testmap/materials/periodic_noise.h"
#include "host/formats/testmap/materials/test_material.h"

namespace multum {
namespace {

constexpr std::size_t kWaves = 56;
constexpr double kLongest = 2.5, kShortest = 60.0;  // waves per side
constexpr double kSteepness = 0.096;                // slope of each long wave; short waves have half of it
constexpr double kSharpness = 1.3;                  // of crests

class Water : public TestMaterial {
 public:
  explicit Water(std::uint64_t seed) {
    SplitMix64 random(seed + 120);
    while (waves_.size() < kWaves) {
      const double share = static_cast<double>(waves_.size()) / (kWaves - 1);
      const double count = kLongest * std::pow(kShortest / kLongest, share);
      const double spread = (random.uniform() + random.uniform() + random.uniform() - 1.5) * 1.5;
      const double turn = 0.6 + spread * (0.7 + 0.6 * share);
      // Whole numbers of waves per side make the water repeat.
      const glm::dvec2 number = glm::round(count * glm::dvec2(std::cos(turn), std::sin(turn)));
      const double phase = random.uniform(), frequency = glm::length(number);
      if (frequency < 1.0) continue;
      const double steepness = kSteepness * std::pow(share < 0.5 ? 1.0 : 1.5 - share, 0.8);
      waves_.push_back({number, phase, steepness / (kWholeTurn * frequency)});
    }
  }

  MaterialPoint at(double u, double v) const override {
    MaterialPoint made;
    for (const Wave& wave : waves_) {
      const double angle = kWholeTurn * (wave.number.x * u + wave.number.y * v + wave.phase);
      made.height += wave.height * std::exp(kSharpness * (std::sin(angle) - 1.0));
    }
    made.colour = {0.004, 0.026, 0.034};
    made.roughness = 0.08;
    return made;
  }

 private:
  struct Wave {
    glm::dvec2 number;
    double phase, height;
  };
  std::vector<Wave> waves_;
};

}  // namespace

std::unique_ptr<TestMaterial> make_water(std::uint64_t seed) { return std::make_unique<Water>(seed); }

}  // namespace multum
