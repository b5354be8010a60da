// SPDX-License-Identifier: Apache-2.0
// Launches movmf_em_texels on given samples from given lobes, and the reference on the same (Han et al. 2007, section
// 7, Algorithm 1): the samples of a case are what the case says, with no map in between. Private to host/lab/selftest.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/source_edit.h"
#include "host/lab/reference/movmf_em.h"
#include "host/lab/reference/numerical_case.h"
#include "kernels/shared/movmf_fit.h"

namespace multum {

constexpr std::size_t kGroup = MULTUM_GROUP;

/// Where bounds of EM's results come from.
constexpr char kEmBoundReason[] =
    "samples' rounding, 6e-8 an addition, times the growth of differences in EM, below 10";

struct EmTexel {
  std::vector<reference::Sample> samples;  // rounded to float before either side sees them
  std::vector<reference::Lobe> lobes;      // the start, likewise; 1..8
};

struct EmSettings {
  bool planar = false;  // Gaussians: samples, lobes and results are as host/lab/reference/planar_em.h has them
  int iterations = 5;
  float kappa_cap = 500.0f;
  float kappa_cap_slope = 10.0f;
  float convergence_tolerance = 0.0f;
};

struct FittedTexel {
  std::vector<glm::dvec4> lobes;  // (r, a); of Gaussians (mean, sigma^2, a)
  std::vector<double> kappa;      // of the last E-step
};

/// The forms of the kernel, which give the same bytes: the device's fast variant, one lane a work-item, and a team of
/// work-items a texel.
enum class EmForm { kFast, kScalar, kTeam };

/// Those that differ on a device; of edited kernels the scalar one alone: what a guard is for shows in one form, and
/// each is a program to build.
std::vector<EmForm> em_forms(const Device& device);
/// Of the numbers of lobes of a case those that a device is tried with: of edited kernels the first alone, likewise.
std::vector<int> em_lobe_counts(const Device& device, const std::vector<int>& counts);

/// Up to 16 texels side by side, all of as many samples, weight and lobes as the first.
std::vector<FittedTexel> fit_texels(Device& device, const std::vector<EmTexel>& texels, const EmSettings& settings,
                                    EmForm form);

/// The reference on one of them.
FittedTexel fit_in_double(const EmTexel& texel, const EmSettings& settings);

/// Adds |a - a'| and |a r - a' r'| of every lobe, of every form of the kernel, against the reference.
void add_em_errors(Device& device, const EmTexel& texel, const EmSettings& settings, const std::string& input,
                   WorstError& worst);

/// One group's buffers as the kernels have them: samples [sample][4][MULTUM_GROUP], and start
/// [lobe][MULTUM_START_PLANES][MULTUM_GROUP] without a prior. Lanes beyond the texels repeat the last.
std::vector<float> packed_samples(const std::vector<EmTexel>& texels);
std::vector<float> packed_start(const std::vector<EmTexel>& texels, bool planar = false);

/// Lobes of equal amplitudes.
std::vector<reference::Lobe> equal_lobes(const std::vector<glm::dvec3>& directions, double kappa);
/// So many samples that repeat `normals`.
std::vector<reference::Sample> repeated(const std::vector<glm::dvec3>& normals, int count);

/// An edit of the kernel.
SourceEdit em_edit(const std::string& text, const std::string& replacement);

/// A unit vector, tilted by so many degrees from +z towards an azimuth in radians.
glm::dvec3 tilted(double degrees, double azimuth = 0.3);

}  // namespace multum
