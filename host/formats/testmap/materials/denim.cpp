// SPDX-License-Identifier: Apache-2.0
// Denim: a twill of blue warp threads, each of which passes over three pale weft threads and under one.
#include <cmath>
#include <glm/common.hpp>

#include "host/formats/testmap/materials/periodic_noise.h"
#include "host/formats/testmap/materials/test_material.h"

namespace multum {
namespace {

constexpr int kThreads = 64;         // per side, a multiple of 4
constexpr double kLift = 0.42;       // height of a thread above the middle plane where it passes over, in threads
constexpr double kThread = 0.62;     // radius of a thread, in distances between threads
constexpr double kFibre = 0.035;     // height of the twisted fibres
constexpr double kWeftDepth = 0.22;  // depth of the weft below the warp

bool is_warp_on_top(int warp, int weft) { return wrapped_cell(warp - weft, 4) != 0; }

class Denim : public TestMaterial {
 public:
  explicit Denim(std::uint64_t seed) : seed_(seed) {}

  MaterialPoint at(double u, double v) const override {
    const double bend = 0.16 * gradient_noise(u, v, 24, seed_ + 40), sag = 0.12 * gradient_noise(u, v, 20, seed_ + 41);
    const Thread warp = thread(u * kThreads + bend, v * kThreads, true);
    Thread weft = thread(v * kThreads + sag, u * kThreads, false);
    weft.height -= kWeftDepth;
    const bool is_warp = warp.height >= weft.height;
    const Thread& top = is_warp ? warp : weft;
    const double fuzz = fractal_noise(u, v, 192, 2, seed_ + 50), wear = fractal_noise(u, v, 4, 4, seed_ + 60);
    MaterialPoint made;
    made.height = (top.height + 0.02 * fuzz) / kThreads;
    // The dye is thin where threads are rubbed.
    const double rubbed = std::clamp(0.35 * smooth_step(0.3, 1.0, top.height) + 0.3 * wear + 0.12 * fuzz, 0.0, 1.0);
    const glm::dvec3 blue = glm::mix(glm::dvec3(0.014, 0.026, 0.075), glm::dvec3(0.12, 0.19, 0.33), rubbed);
    const glm::dvec3 pale = glm::dvec3(0.36, 0.37, 0.36) * (0.75 + 0.4 * top.tint);
    made.colour = glm::clamp((is_warp ? blue * (0.7 + 0.6 * top.tint) : pale) * (1.0 + 0.15 * fuzz), 0.0, 1.0);
    made.roughness = std::clamp(0.72 + 0.1 * fuzz, 0.0, 1.0);
    return made;
  }

 private:
  struct Thread {
    double height = -1.0, tint = 0.5;
  };

  // Returns the highest of the threads of one direction. `across` and `along` are in distances between threads.
  Thread thread(double across, double along, bool is_warp) const {
    Thread best;
    const int near = static_cast<int>(std::floor(across));
    for (int i = near - 1; i <= near + 1; ++i) {
      const double tint = cell_random(wrapped_cell(i, kThreads), is_warp ? 1 : 2, 4, seed_);
      const double side = (across - i - 0.5) / (kThread * (0.9 + 0.2 * tint));
      if (std::abs(side) >= 1.0) continue;
      const int crossing = static_cast<int>(std::floor(along - 0.5));
      const auto lift = [&](int at) {
        return is_warp_on_top(is_warp ? i : at, is_warp ? at : i) == is_warp ? kLift : -kLift;
      };
      const double twist = std::sin(kWholeTurn * (2.0 * along + 0.9 * side + tint)) +
                           0.6 * std::sin(kWholeTurn * (3.0 * along - 1.6 * side));
      const double height = glm::mix(lift(crossing), lift(crossing + 1), smooth(along - 0.5 - crossing)) +
                            kThread * std::sqrt(1.0 - side * side) + kFibre * twist;
      if (height > best.height) best = {height, tint};
    }
    return best;
  }

  const std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<TestMaterial> make_denim(std::uint64_t seed) { return std::make_unique<Denim>(seed); }

}  // namespace multum
