// SPDX-License-Identifier: Apache-2.0
// Tests the refinement of lobes (kernels/movmf_refine.cl) with texels for which formulas without guards fail.
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>

#include "host/lab/reference/movmf_refine.h"
#include "host/lab/selftest/case_lists.h"
#include "host/lab/selftest/em_launch.h"
#include "kernels/shared/movmf_refine.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

// Refines a texel in a level of one row. The texel has at most one neighbour, on its right.
std::vector<MultumVmfLobe> refine_texel(Device& device, const reference::RefinedTexel& texel, int vector_width) {
  const std::vector<reference::Sample>& samples = texel.samples;
  const std::size_t width = 1 + texel.beside.size();
  const std::vector<float> packed = packed_samples({EmTexel{samples, {}}});
  const std::vector<int> counts = {static_cast<int>(samples.size())};
  std::vector<int> list(kGroup, -1);
  list[0] = 0;
  std::vector<MultumVmfLobe> level;
  for (std::size_t j = 0; j < texel.lobes.size(); ++j)
    for (std::size_t x = 0; x < width; ++x) {
      const reference::MeanLobe& lobe = x == 0 ? texel.lobes[j] : texel.beside[0][j];
      level.push_back({static_cast<float>(lobe.r.x), static_cast<float>(lobe.r.y), static_cast<float>(lobe.r.z),
                       static_cast<float>(lobe.amplitude)});
    }
  MultumMovmfFit fit = {};
  fit.map_width = fit.width = static_cast<int>(width);
  fit.slot_count = MULTUM_GROUP;
  fit.map_height = fit.height = fit.window_rows = fit.map_window_rows = 1;
  fit.sample_capacity = counts[0];
  double total = 0.0;
  for (const reference::Sample& sample : samples) total += sample.weight;
  fit.total_weight_inverse = static_cast<float>(1.0 / total);
  const std::size_t level_bytes = level.size() * sizeof(MultumVmfLobe);
  const DeviceBuffer sample_buffer = device.wrap_buffer(packed.data(), packed.size() * sizeof(float), "samples");
  const DeviceBuffer count_buffer = device.wrap_buffer(counts.data(), sizeof(int), "sample counts");
  const DeviceBuffer list_buffer = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  const DeviceBuffer level_buffer = device.wrap_buffer(level.data(), level_bytes, "lobes");
  DeviceBuffer refined_buffer = device.make_buffer(level_bytes, "refined lobes");
  device.kernel("movmf_refine", "movmf_refine", {static_cast<int>(texel.lobes.size()), vector_width, true})
      .launch({kGroup / static_cast<std::size_t>(vector_width)}, sample_buffer, count_buffer, list_buffer, level_buffer,
              refined_buffer, fit);
  std::vector<MultumVmfLobe> refined(level.size()), first;
  device.read(refined_buffer, refined.data(), level_bytes);
  for (std::size_t j = 0; j < texel.lobes.size(); ++j) first.push_back(refined[j * width]);
  return first;
}

void compare(Device& device, const reference::RefinedTexel& texel, WorstError& worst) {
  const std::vector<reference::MeanLobe> expected = reference::refine(texel, MULTUM_REFINE_STEPS);
  for (const int width : device.kernels_are_edited() ? std::vector<int>{1} : std::vector<int>{1, 16}) {
    const std::vector<MultumVmfLobe> found = refine_texel(device, texel, width);
    for (std::size_t j = 0; j < found.size(); ++j) {
      const glm::dvec3 r(found[j].mean_x, found[j].mean_y, found[j].mean_z);
      const double a = static_cast<double>(found[j].amplitude);
      worst.add(a, expected[j].amplitude, 1.0, "amplitude");
      worst.add(glm::length(a * r - expected[j].amplitude * expected[j].r), "a r");
    }
  }
}

// Tests a lobe with r = 0, which has no direction and no sharpness.
void lobe_without_direction(Device& device, WorstError& worst) {
  const std::vector<reference::MeanLobe> lobes = {{glm::dvec3(0.0), 0.5}, {{0.6, 0.0, 0.6}, 0.5}};
  compare(device, {repeated({{0.6, 0.0, 0.8}, {-0.6, 0.0, 0.8}}, 64), lobes, {}}, worst);
}

// Tests lobes that are opposite to the lobes of the neighbour. The mixed vector has length 0, and no lobe may turn.
void opposite_lobes_beside(Device& device, WorstError& worst) {
  const std::vector<reference::MeanLobe> lobes = {{{0.0, 0.0, 0.75}, 0.5}, {{0.5, 0.0, 0.5}, 0.5}};
  const std::vector<reference::MeanLobe> beside = {{{0.0, 0.0, -0.75}, 0.5}, {{-0.5, 0.0, -0.5}, 0.5}};
  compare(device, {repeated({{0.6, 0.0, 0.8}, {-0.6, 0.0, 0.8}}, 64), lobes, {beside}}, worst);
}

}  // namespace

std::vector<NumericalCase> refine_cases() {
  return {
      {{"refined-lobes-without-direction", "movmf_refine", "computing the peak of a lobe with kappa 0 divides 0 by 0",
        "kappa is at least 0.05", 2e-3, "absolute error of the lobe's amplitude a and of the vector a r",
        "each of ten damped steps adds the error of the polynomial for kappa, which is 3e-5"},
       lobe_without_direction,
       {{"movmf_refine", "MAX_V(kappa_of_mean_length(mean, spread), (real_v)(MULTUM_REFINE_KAPPA_MIN))",
         "kappa_of_mean_length(mean, spread)"}}},
      {{"refined-beside-opposite-lobes", "movmf_refine",
        "the sum of two opposite lobes can have length 0, and rotating a vector of length 0 divides by zero",
        "a length below 0.02 is replaced by 0.02", 2e-3,
        "absolute error of the lobe's amplitude a and of the vector a r",
        "each of ten damped steps adds the error of the polynomial for kappa, which is 3e-5"},
       opposite_lobes_beside,
       {{"movmf_refine", "1.0f / MAX_V(length, (real_v)(MULTUM_REFINE_LENGTH_MIN))", "1.0f / length"}}}};
}

}  // namespace multum
