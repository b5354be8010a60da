// SPDX-License-Identifier: Apache-2.0
// Runs the EM kernels on the texels of one level of a map from given initial lobes. Runs the reference on the same
// texels.
#pragma once

#include <vector>

#include "host/bakes/movmf/mip_schedule.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/lab/reference/movmf_em.h"
#include "kernels/shared/movmf_fit.h"
#include "kernels/shared/vmf_lobe.h"
#include "tests/fixtures/test_device.h"

namespace multum::testing {

struct LevelFit {
  int level = 1;
  int iterations = 5;
  float alignment = 0.1f;
  float kappa_cap = 500.0f;
  float kappa_cap_slope = 10.0f;
  bool scalar = false;
  bool shortened = false;                 // the lengths of normals encode the width of a BRDF
  FitMethod method = FitMethod::kTexels;  // kTexels: levels of up to 1024 normals per texel
  int bin_rows = 1 << 15;                 // the number of map rows in each band of binning
  float convergence_tolerance = 0.0f;
  // For kGmm, the lobes and the r of the reference are (mean x, mean y, sigma^2, amplitude).
  Representation representation = Representation::kMovmf;
};

/// Fits every texel of a level in one step from the lobes `parent` [lobe][parent texel]. The neighbours are not fitted
/// yet, so the prior comes only from the parent. Returns [lobe][texel].
std::vector<MultumVmfLobe> fit_with_kernels(const NormalMap& map, const std::vector<MultumVmfLobe>& parent,
                                            int lobe_count, const LevelFit& how);

/// Fits the same texels with the reference.
std::vector<reference::Moments> fit_with_reference(const NormalMap& map, const std::vector<MultumVmfLobe>& parent,
                                                   int lobe_count, const LevelFit& how);

/// Returns the texels of the finest level that texel (x, y) of a level covers, with their exact shares.
std::vector<reference::Sample> covered_samples(const NormalMap& map, int level, int x, int y);

}  // namespace multum::testing
