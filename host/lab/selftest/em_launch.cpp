// SPDX-License-Identifier: Apache-2.0
#include "host/lab/selftest/em_launch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/formats/opencl/launch_shape.h"
#include "host/foundation/base/error.h"
#include "host/lab/reference/planar_em.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {
namespace {

double rounded(double value) { return static_cast<double>(static_cast<float>(value)); }
glm::dvec3 rounded(const glm::dvec3& v) { return {rounded(v.x), rounded(v.y), rounded(v.z)}; }

// Rounds the inputs from which both the kernel and the reference start.
EmTexel rounded(EmTexel texel) {
  for (reference::Sample& s : texel.samples) s = {rounded(s.normal), rounded(s.weight)};
  for (reference::Lobe& lobe : texel.lobes)
    lobe = {rounded(lobe.mu), rounded(lobe.kappa * std::numbers::log2e) / std::numbers::log2e, rounded(lobe.amplitude)};
  return texel;
}

double total_weight(const EmTexel& texel) {
  return std::accumulate(texel.samples.begin(), texel.samples.end(), 0.0,
                         [](double sum, const reference::Sample& s) { return sum + s.weight; });
}

const EmTexel& of_lane(const std::vector<EmTexel>& texels, std::size_t lane) {
  return texels[std::min(lane, texels.size() - 1)];
}

}  // namespace

std::vector<float> packed_samples(const std::vector<EmTexel>& texels) {
  const std::size_t count = texels.front().samples.size();
  std::vector<float> packed(count * 4 * kGroup);
  for (std::size_t lane = 0; lane < kGroup; ++lane)
    for (std::size_t i = 0; i < count; ++i) {
      const reference::Sample& s = of_lane(texels, lane).samples.at(i);
      const double values[4] = {s.normal.x, s.normal.y, s.normal.z, s.weight};
      for (std::size_t k = 0; k < 4; ++k) packed[(i * 4 + k) * kGroup + lane] = static_cast<float>(values[k]);
    }
  return packed;
}

std::vector<float> packed_start(const std::vector<EmTexel>& texels, bool planar) {
  std::vector<float> packed(texels.front().lobes.size() * MULTUM_START_PLANES * kGroup, 0.0f);
  for (std::size_t lane = 0; lane < kGroup; ++lane)
    for (std::size_t j = 0; j < texels.front().lobes.size(); ++j) {
      const reference::Lobe& lobe = of_lane(texels, lane).lobes.at(j);
      const auto put = [&](std::size_t plane, double value) {
        packed[(j * MULTUM_START_PLANES + plane) * kGroup + lane] = static_cast<float>(value);
      };
      put(MULTUM_START_MU, lobe.mu.x);
      put(MULTUM_START_MU + 1, lobe.mu.y);
      put(MULTUM_START_MU + 2, lobe.mu.z);
      put(MULTUM_START_SHARPNESS, lobe.kappa * std::numbers::log2e);
      const double below = planar ? 1.0 : -std::expm1(-2.0 * lobe.kappa);
      put(MULTUM_START_LOG, std::log2(std::max(lobe.amplitude, 1e-6) * lobe.kappa / below));
    }
  return packed;
}

namespace {

MultumMovmfFit one_group_fit(const EmTexel& texel, const EmSettings& settings) {
  MultumMovmfFit fit = {};
  fit.map_width = fit.width = MULTUM_GROUP;
  fit.map_height = fit.height = fit.window_rows = fit.map_window_rows = 1;
  fit.slot_count = MULTUM_GROUP;
  fit.iteration_count = settings.iterations;
  fit.sample_capacity = static_cast<int>(texel.samples.size());
  fit.convergence_tolerance_squared = settings.convergence_tolerance * settings.convergence_tolerance;
  fit.kappa_cap = settings.kappa_cap;
  fit.kappa_cap_slope = settings.kappa_cap_slope;
  fit.total_weight_inverse = static_cast<float>(1.0 / total_weight(texel));
  return fit;
}

}  // namespace

std::vector<reference::Lobe> equal_lobes(const std::vector<glm::dvec3>& directions, double kappa) {
  std::vector<reference::Lobe> lobes;
  for (const glm::dvec3& mu : directions) lobes.push_back({mu, kappa, 1.0 / static_cast<double>(directions.size())});
  return lobes;
}

std::vector<reference::Sample> repeated(const std::vector<glm::dvec3>& normals, int count) {
  std::vector<reference::Sample> samples;
  for (int i = 0; i < count; ++i) samples.push_back({normals[static_cast<std::size_t>(i) % normals.size()], 1.0});
  return samples;
}

SourceEdit em_edit(const std::string& text, const std::string& replacement) {
  return {"movmf_em_texels", text, replacement};
}

glm::dvec3 tilted(double degrees, double azimuth) {
  const double t = degrees * std::numbers::pi / 180.0;
  return {std::sin(t) * std::cos(azimuth), std::sin(t) * std::sin(azimuth), std::cos(t)};
}

std::vector<EmForm> em_forms(const Device& device) {
  if (device.kernels_are_edited()) return {EmForm::kScalar};
  if (device.shape().vector_width == 1) return {EmForm::kScalar, EmForm::kTeam};
  return {EmForm::kFast, EmForm::kScalar, EmForm::kTeam};
}

std::vector<int> em_lobe_counts(const Device& device, const std::vector<int>& counts) {
  return device.kernels_are_edited() ? std::vector<int>{counts.front()} : counts;
}

std::vector<FittedTexel> fit_texels(Device& device, const std::vector<EmTexel>& given, const EmSettings& settings,
                                    EmForm form) {
  MULTUM_CHECK(!given.empty() && given.size() <= kGroup);
  std::vector<EmTexel> texels;
  for (const EmTexel& texel : given) texels.push_back(rounded(texel));
  const std::size_t lobe_count = texels.front().lobes.size();
  const std::vector<float> samples = packed_samples(texels);
  std::vector<float> start = packed_start(texels, settings.planar);
  const std::vector<int> sample_counts = {static_cast<int>(texels.front().samples.size())};
  std::vector<int> list(kGroup);
  std::iota(list.begin(), list.end(), 0);
  // Poison values show which values the kernel did not write.
  std::vector<MultumVmfLobe> level(lobe_count * kGroup, MultumVmfLobe{NAN, NAN, NAN, NAN});
  const std::size_t level_bytes = level.size() * sizeof(MultumVmfLobe);
  const DeviceBuffer sample_buffer = device.wrap_buffer(samples.data(), samples.size() * sizeof(float), "samples");
  const DeviceBuffer count_buffer = device.wrap_buffer(sample_counts.data(), sizeof(int), "sample counts");
  const DeviceBuffer list_buffer = device.wrap_buffer(list.data(), list.size() * sizeof(int), "texels");
  DeviceBuffer start_buffer = device.make_buffer(start.size() * sizeof(float), "start");
  DeviceBuffer level_buffer = device.make_buffer(level_bytes, "lobes");
  const DeviceBuffer alignment_buffer = device.make_buffer(level_bytes, "directions");
  device.write(start_buffer, start.data(), start_buffer.byte_count());
  device.write(level_buffer, level.data(), level_bytes);
  const bool by_team = form == EmForm::kTeam;
  const int width = form == EmForm::kFast ? device.shape().vector_width : 1;
  const Kernel::WorkSize size = by_team ? Kernel::WorkSize{kGroup * MULTUM_TEAM, MULTUM_TEAM}
                                        : Kernel::WorkSize{kGroup / static_cast<std::size_t>(width)};
  device
      .kernel("movmf_em_texels", by_team ? "movmf_em_team" : "movmf_em_texels",
              {static_cast<int>(lobe_count), width, true, settings.planar})
      .launch(size, sample_buffer, count_buffer, start_buffer, list_buffer, level_buffer, alignment_buffer,
              one_group_fit(texels.front(), settings));
  device.read(level_buffer, level.data(), level_bytes);
  device.read(start_buffer, start.data(), start_buffer.byte_count());
  std::vector<FittedTexel> fitted(texels.size());
  for (std::size_t lane = 0; lane < texels.size(); ++lane)
    for (std::size_t j = 0; j < lobe_count; ++j) {
      const MultumVmfLobe& lobe = level[j * kGroup + lane];
      fitted[lane].lobes.emplace_back(lobe.mean_x, lobe.mean_y, lobe.mean_z, lobe.amplitude);
      fitted[lane].kappa.push_back(
          static_cast<double>(start[(j * MULTUM_START_PLANES + MULTUM_START_SHARPNESS) * kGroup + lane]) /
          std::numbers::log2e);
    }
  return fitted;
}

FittedTexel fit_in_double(const EmTexel& given, const EmSettings& settings) {
  const EmTexel texel = rounded(given);
  std::vector<reference::Lobe> lobes = texel.lobes;
  const reference::EmOptions options = {
      settings.iterations, static_cast<double>(settings.kappa_cap), static_cast<double>(settings.kappa_cap_slope), {}};
  const std::vector<reference::Moments> moments = settings.planar ? reference::fit_planar(texel.samples, lobes, options)
                                                                  : reference::fit(texel.samples, lobes, options);
  FittedTexel fitted;
  for (std::size_t j = 0; j < lobes.size(); ++j) {
    fitted.lobes.emplace_back(moments[j].r, moments[j].amplitude);
    fitted.kappa.push_back(lobes[j].kappa);
  }
  return fitted;
}

void add_em_errors(Device& device, const EmTexel& texel, const EmSettings& settings, const std::string& input,
                   WorstError& worst) {
  const FittedTexel expected = fit_in_double(texel, settings);
  for (const EmForm form : em_forms(device)) {
    const FittedTexel found = fit_texels(device, {texel}, settings, form).front();
    for (std::size_t j = 0; j < expected.lobes.size(); ++j) {
      const glm::dvec4 &f = found.lobes[j], &e = expected.lobes[j];
      worst.add(f.w, e.w, 1.0, input);
      worst.add(glm::length(f.w * glm::dvec3(f) - e.w * glm::dvec3(e)), input);
    }
  }
}

}  // namespace multum
