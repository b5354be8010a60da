// SPDX-License-Identifier: Apache-2.0
// Converts lobes between the kernels' format and the file format.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/movmf/fit_report.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

struct LobeRowsSize {
  int width, height, lobe_count;
  Representation representation = Representation::kMovmf;
  bool has_colours = false;
  int weight_count = 0;
};

/// `lobes` holds r and a in rows [lobe][column]. For Gaussians, it holds the mean, sigma^2 and a. `features` holds rows
/// [triple][lobe][column]. Returns planes of (a r, a), or Gaussians as in host/formats/asset/lobes/gmm_quantize.h. The
/// shares of every texel sum to 1. Counts rare numerical events in `report`. `kappa_cap` is MovmfSettings::kappa_cap.
MovmfLevel stored_rows(const LobeRowsSize& size, const MultumVmfLobe* lobes, const std::vector<glm::vec3>& features,
                       float kappa_cap, int threads, FitReport& report);

/// Converts one stored lobe to the kernels' format.
MultumVmfLobe fitted_lobe(const glm::vec4& stored, Representation representation);

}  // namespace multum
