// SPDX-License-Identifier: Apache-2.0
// Fits one GGX lobe to each texel of every mip level of a normal map (kernels/one_lobe.cl): by maximum likelihood of
// its facets' slopes, or in closed form. The map is averaged in one pass by bands of rows
// (host/bakes/pyramid/average_pass.h) which gives every fit its start; rows of a level are fitted as soon as their
// averages are done, from samples of the finest texels.
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
  bool is_fast = false;         // the closed form alone
  double base_roughness = 0.5;  // perceptual, 0..1, where no map has it
  // Of EM, 1..100. On five real maps at base roughness 0.1 and 0.25 the mean error of levels 2, 4 and 6 is within 0.5 %
  // of itself, relative, of what 8 steps have, but for the darkest cells of re_floor03_n at 0.1 (2 %).
  int iteration_count = 5;
};

struct OneLobeInputs {
  const PlaneStore* normals = nullptr;
  // Levels from 1 on are fitted to these points of the surface between texels (host/formats/image/surface_points.h);
  // null: to `normals`.
  const PlaneStore* surface = nullptr;
  // alpha^2, occlusion, metalness: of the same size. Null: alpha is that of base_roughness, and there are no others.
  const PlaneStore* material = nullptr;
  bool has_roughness = false, has_occlusion = false, has_metalness = false;  // which of its planes are of maps
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;                       // for buffers; changes no byte
  int threads = 1;
  bool wants_means = false;       // MaterialRows::means
  FitJournal* journal = nullptr;  // has rows that need no fit, and takes those that are fitted; null: none

  const PlaneStore& fitted_normals() const { return surface != nullptr ? *surface : *normals; }
};

struct OneLobeReport {
  std::string plan;       // bands, a line
  double axis_cut = 0.0;  // angle at which axes change their sign, radians
};

/// The least alpha that is exported: highlights of smoother lobes are narrower than any light.
constexpr double kAlphaMin = 1e-3;

/// Throws Error(kUsage) for settings out of range.
void validate(const OneLobeSettings& settings);

/// Hands all levels, the finest too, to `sink`. Throws Error(kUsage) for too little memory, Error(kEnvironment) when
/// disk or device refuse, Cancelled. Progress: a unit a texel of the map.
OneLobeReport fit_one_lobe(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                           MaterialSink& sink, Progress* progress);

}  // namespace multum
