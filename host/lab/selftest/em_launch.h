// SPDX-License-Identifier: Apache-2.0
// Launches movmf_em_texels with given samples and starting lobes, and runs the reference with the same inputs (Han et
// al. 2007, section 7, Algorithm 1). A case specifies its samples directly, without a map. Private to
// host/lab/selftest.
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

/// The reason for the bounds of EM results.
constexpr char kEmBoundReason[] =
    "each addition has a rounding error of up to 6e-8, and EM multiplies these errors by less than 10";

struct EmTexel {
  std::vector<reference::Sample> samples;  // samples, which are rounded to float for both sides
  std::vector<reference::Lobe> lobes;      // 1 to 8 lobes from which EM starts, also rounded to float
};

struct EmSettings {
  bool planar = false;  // whether lobes are Gaussians, as in host/lab/reference/planar_em.h
  int iterations = 5;
  float kappa_cap = 500.0f;
  float kappa_cap_slope = 10.0f;
  float convergence_tolerance = 0.0f;
};

struct FittedTexel {
  std::vector<glm::dvec4> lobes;  // (r, a) of each lobe; (mean, sigma^2, a) of each Gaussian
  std::vector<double> kappa;      // kappa of the last E-step
};

/// The forms of the kernel, which all give the same bytes. They are the device's fast variant, one lane per work-item,
/// and a team of work-items per texel.
enum class EmForm { kFast, kScalar, kTeam };

/// Returns the forms that differ on a device. Edited kernels run only in the scalar form, because one form is enough to
/// show the effect of a guard, and each form is another program to build.
std::vector<EmForm> em_forms(const Device& device);
/// Returns the numbers of lobes of a case that are tested on a device. Edited kernels run only with the first number.
std::vector<int> em_lobe_counts(const Device& device, const std::vector<int>& counts);

/// Fits up to 16 adjacent texels. All texels have as many samples, weights and lobes as the first texel.
std::vector<FittedTexel> fit_texels(Device& device, const std::vector<EmTexel>& texels, const EmSettings& settings,
                                    EmForm form);

/// Runs the reference on one texel.
FittedTexel fit_in_double(const EmTexel& texel, const EmSettings& settings);

/// For every lobe and every form of the kernel, adds the differences |a - a'| and |a r - a' r'| between kernel and
/// reference.
void add_em_errors(Device& device, const EmTexel& texel, const EmSettings& settings, const std::string& input,
                   WorstError& worst);

/// Contains the buffers of one group in the layout of the kernels: samples [sample][4][MULTUM_GROUP], and start
/// [lobe][MULTUM_START_PLANES][MULTUM_GROUP] without a prior. Surplus lanes repeat the last texel.
std::vector<float> packed_samples(const std::vector<EmTexel>& texels);
std::vector<float> packed_start(const std::vector<EmTexel>& texels, bool planar = false);

/// Makes lobes of equal amplitudes.
std::vector<reference::Lobe> equal_lobes(const std::vector<glm::dvec3>& directions, double kappa);
/// Makes `count` samples by repeating `normals`.
std::vector<reference::Sample> repeated(const std::vector<glm::dvec3>& normals, int count);

/// Returns an edit of the kernel's text.
SourceEdit em_edit(const std::string& text, const std::string& replacement);

/// Returns a unit vector that is tilted by `degrees` from +z. The azimuth is in radians.
glm::dvec3 tilted(double degrees, double azimuth = 0.3);

}  // namespace multum
