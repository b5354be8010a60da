// SPDX-License-Identifier: Apache-2.0
// Fits one GGX lobe to each texel of every mip level of a normal map (kernels/one_lobe.cl). The fit uses maximum
// likelihood of the facets' slopes, or a closed form. One pass averages the map in bands of rows
// (host/bakes/pyramid/average_pass.h). The fits start from these averages. Rows of a level are fitted from samples of
// the finest texels as soon as their averages are done.
#pragma once

#include <cstdint>
#include <string>

#include "host/delivery/export/fit_journal.h"
#include "host/delivery/export/material_rows.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct OneLobeSettings {
  bool is_anisotropic = false;
  bool is_fast = false;         // use only the closed form
  double base_roughness = 0.5;  // perceptual, 0..1; used if there is no roughness map
  // Number of EM steps, 1..100. On five real maps at base roughness 0.1 and 0.25, the mean error of levels 2, 4 and 6
  // is within 0.5 % of the error with 8 steps. In the darkest cells of re_floor03_n at roughness 0.1, the two errors
  // differ by 2 %.
  int iteration_count = 5;
};

struct OneLobeInputs {
  const PlaneStore* normals = nullptr;
  // Points of the surface between texels, to which levels 1 and coarser are fitted
  // (host/formats/image/surface_points.h). If null, these levels are fitted to `normals`.
  const PlaneStore* surface = nullptr;
  // Planes of alpha^2, occlusion and metalness, with the same size. If null, alpha follows from base_roughness, and
  // there is no occlusion or metalness.
  const PlaneStore* material = nullptr;
  bool has_roughness = false, has_occlusion = false, has_metalness = false;  // true for planes that come from maps
  // Memory for buffers. Does not change the result.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  int threads = 1;
  bool wants_means = false;       // fill MaterialRows::means
  FitJournal* journal = nullptr;  // supplies rows that were already fitted, and stores fitted rows; may be null

  const PlaneStore& fitted_normals() const { return surface != nullptr ? *surface : *normals; }
};

struct OneLobeReport {
  std::string plan;       // the bands, as one line of text
  double axis_cut = 0.0;  // angle at which axes change their sign, radians
};

/// The smallest exported alpha. Highlights of smoother lobes would be narrower than any light.
constexpr double kAlphaMin = 1e-3;

/// Throws Error(kUsage) for settings out of range.
void validate(const OneLobeSettings& settings);

/// Passes all levels to `sink`, including the finest. Throws Error(kUsage) if the memory is too small,
/// Error(kEnvironment) if the disk or device fails, and Cancelled. Progress: one unit per texel of the map.
OneLobeReport fit_one_lobe(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                           MaterialSink& sink, Progress* progress);

}  // namespace multum
