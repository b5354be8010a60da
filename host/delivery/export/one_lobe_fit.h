// SPDX-License-Identifier: Apache-2.0
// Fits one GGX lobe to each texel of every mip level of a normal map (kernels/one_lobe.cl). The fit maximizes the
// likelihood of the facets' slopes, or uses a closed form. One pass averages the map in bands of rows
// (host/bakes/pyramid/average_pass.h), and the fits start from these averages. Rows of a level are fitted to samples of
// the finest texels as soon as their averages are complete.
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
  // The number of EM steps, 1..100. On five real maps at base roughness 0.1 and 0.25, the mean error of levels 2, 4 and
  // 6 with the default differs from the error with 8 steps by less than 0.5 %. In the darkest cells of re_floor03_n at
  // roughness 0.1, the two errors differ by 2 %.
  int iteration_count = 5;
};

struct OneLobeInputs {
  const PlaneStore* normals = nullptr;
  // The points of the interpolated surface to which levels 1 and coarser are fitted
  // (host/formats/image/surface_points.h). If null, these levels are fitted to `normals`.
  const PlaneStore* surface = nullptr;
  // The planes of alpha^2, occlusion and metalness, which have the same size. If null, alpha is computed from
  // base_roughness, and there is no occlusion or metalness.
  const PlaneStore* material = nullptr;
  bool has_roughness = false, has_occlusion = false, has_metalness = false;  // true for planes that come from maps
  // Memory for buffers. Does not change the result.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  int threads = 1;
  bool wants_means = false;       // fill MaterialRows::means
  FitJournal* journal = nullptr;  // provides rows that were fitted earlier, and stores newly fitted rows; may be null

  const PlaneStore& fitted_normals() const { return surface != nullptr ? *surface : *normals; }
};

struct OneLobeReport {
  std::string plan;       // the bands, as one line of text
  double axis_cut = 0.0;  // angle at which axes change their sign, radians
};

/// The smallest exported alpha. The highlights of smoother lobes would be narrower than any light.
constexpr double kAlphaMin = 1e-3;

/// Throws Error(kUsage) for settings out of range.
void validate(const OneLobeSettings& settings);

/// Passes all levels to `sink`, including the finest. Throws Error(kUsage) if the memory is too small,
/// Error(kEnvironment) if the disk or device fails, and Cancelled. Progress: one unit per texel of the map.
OneLobeReport fit_one_lobe(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                           MaterialSink& sink, Progress* progress);

}  // namespace multum
