// SPDX-License-Identifier: Apache-2.0
// 8-bit values are recognized in any type. Otherwise, the step is the greatest common divisor of the differences
// between values. The divisor is used for integers, and for floats that are whole numbers. The step is 1 if all 16 bits
// are used.
#include "host/formats/image/normals/height_steps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>

#include <fmt/format.h>

#include "host/formats/image/files/number_type.h"

namespace multum {
namespace {

constexpr int kStepRowsMax = 512;

// Checks whether values are multiples of 1 / unit, within a tolerance. With Step::kFound, also finds the largest step,
// which is a multiple of 1 / unit.
class Lattice {
 public:
  enum class Step { kOne, kFound };
  Lattice(double unit, double tolerance, Step step) : unit_(unit), tolerance_(tolerance), step_(step) {}

  void add(const float* values, int count) {
    constexpr double kCodeMax = 1e12;
    for (int i = 0; i < count && holds_; ++i) {
      if (!std::isfinite(values[i])) continue;
      const double scaled = static_cast<double>(values[i]) * unit_;
      const double rounded_code = std::round(scaled);
      holds_ = std::abs(scaled) < kCodeMax && std::abs(scaled - rounded_code) <= tolerance_;
      if (!holds_) return;
      const auto code = static_cast<std::int64_t>(rounded_code);
      if (!first_) first_ = low_ = high_ = code;
      if (divisor_ != 1) divisor_ = std::gcd(divisor_, code - *first_);
      low_ = std::min(low_, code);
      high_ = std::max(high_, code);
    }
  }
  // A map with few distinct values is a mask, or a shape with few levels. The differences between its values are not
  // rounding steps.
  double step() const {
    constexpr std::int64_t kStepsMin = 15;
    if (!holds_ || divisor_ == 0) return 0.0;
    if (step_ == Step::kOne) return 1.0 / unit_;
    return high_ - low_ >= kStepsMin * divisor_ ? static_cast<double>(divisor_) / unit_ : 0.0;
  }

 private:
  double unit_, tolerance_;
  Step step_;
  bool holds_ = true;
  std::optional<std::int64_t> first_;
  std::int64_t divisor_ = 0, low_ = 0, high_ = 0;
};

// Returns the grids of values to try, beginning with the coarsest. The first ones are for 8 bits, as v * 257, v * 256
// or v / 255.
std::vector<Lattice> lattices(const HeightSurface& surface) {
  using Step = Lattice::Step;
  const RawImageInfo& info = surface.info();
  const HeightReading& reading = surface.reading();
  if (reading.coding == HeightCoding::kTerrarium) return {Lattice(256.0, 1e-3, Step::kFound)};
  if (reading.coding == HeightCoding::kMapbox) return {Lattice(10.0, 0.05, Step::kFound)};
  const Lattice codes(value_unit(info, reading), 0.1, Step::kFound);
  if (reading.coding != HeightCoding::kGrey) return {codes};
  if (info.base_type == number_type::kUint16)
    return {Lattice(255.0, 1e-3, Step::kOne), Lattice(65535.0 / 256.0, 1e-3, Step::kOne), codes};
  // Half floats have steps of up to 0.12 times the steps of 8 bits, so they get a larger tolerance.
  if (is_float_type(info.sample_type))
    return {Lattice(255.0, info.base_type == number_type::kHalf ? 0.065 : 1e-3, Step::kOne),
            Lattice(1.0, 0.0, Step::kFound)};
  return {codes};
}

// Compression does not change the step of 8-bit files.
double known_step(const HeightSurface& surface) {
  const bool is_byte =
      surface.info().base_type == number_type::kUint8 && surface.reading().coding == HeightCoding::kGrey;
  return is_byte ? 1.0 / 255.0 : 0.0;
}

// Counts triples of texels in a line. At the edge of a terrace, two texels are equal and the third differs by one step.
// On slopes and in noise, both pairs of neighbours differ.
struct StepCounts {
  double edges = 0.0, others = 0.0;

  void add(float a, float b, float c, double step) {
    const auto steps = [step](float from, float to) {
      return std::abs(static_cast<double>(to) - static_cast<double>(from)) / step;
    };
    const double first = steps(a, b), second = steps(b, c);
    const double larger = std::max(first, second), smaller = std::min(first, second);
    if (larger > 0.5 && larger <= 1.5 && smaller <= 0.5) edges += 1.0;
    else if (larger > 0.5) others += 1.0;  // false for texels without a height
  }
};

}  // namespace

double HeightSteps::degrees(double height_scale) const {
  return std::atan(0.5 * std::abs(height_scale) * step) * 180.0 / std::numbers::pi;
}

// A step of 1 degree is twice the step of an 8-bit normal map. On steep heights, neighbours are several steps apart, so
// one step matters little.
bool HeightSteps::are_terraces(double height_scale) const {
  constexpr double kDegreesMin = 1.0, kEdgeShareMin = 0.5;
  return step > 0.0 && edge_share >= kEdgeShareMin && degrees(height_scale) >= kDegreesMin;
}

HeightSteps measure_steps(const HeightSurface& surface) {
  const int width = surface.width(), height = surface.height(), count = std::min(kStepRowsMax, height);
  const auto row_of = [&](int i) { return static_cast<int>(static_cast<std::int64_t>(i) * height / count); };
  const auto for_each_group = [&](const auto& body) {
    for (int i = 0; i < count; ++i) body(surface.rows(row_of(i), std::min(height, row_of(i) + 3), 0), row_of(i));
  };
  HeightSteps steps;
  steps.step = known_step(surface);
  if (steps.step == 0.0) {
    std::vector<Lattice> candidates = lattices(surface);
    for_each_group([&](const HeightRows& rows, int) {
      for (Lattice& lattice : candidates) lattice.add(rows.values.data(), static_cast<int>(rows.values.size()));
    });
    for (const Lattice& lattice : candidates)
      if (steps.step == 0.0) steps.step = lattice.step();
  }
  if (steps.step == 0.0) return steps;
  StepCounts counts;
  for_each_group([&](const HeightRows& rows, int row) {
    const float *const own = rows.row(row), *const below = row + 2 < height ? rows.row(row + 1) : nullptr;
    for (int i = 0; i + 2 < width; ++i) counts.add(own[i], own[i + 1], own[i + 2], steps.step);
    if (below == nullptr) return;
    const float* const next = rows.row(row + 2);
    for (int i = 0; i < width; ++i) counts.add(own[i], below[i], next[i], steps.step);
  });
  if (counts.edges + counts.others > 0.0) steps.edge_share = counts.edges / (counts.edges + counts.others);
  return steps;
}

std::string step_text(const HeightSteps& steps, const HeightSurface& surface) {
  constexpr double kByte = 1.0 / 255.0;
  if (std::abs(steps.step - kByte) < 0.005 * kByte) {
    const bool is_byte = surface.info().base_type == number_type::kUint8;
    return is_byte ? "1/255 (8 bits)" : "1/255 (8-bit values in a wider format)";
  }
  return fmt::format("{:.4g}{}", steps.step * value_unit(surface.info(), surface.reading()),
                     is_float_type(surface.info().sample_type) ? "" : " in the units of the file");
}

}  // namespace multum
