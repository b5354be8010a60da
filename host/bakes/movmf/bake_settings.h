// SPDX-License-Identifier: Apache-2.0
// Holds the settings for fitting lobes. The rows of bake_parameters() define the ranges, the displayed names and the
// names in the settings hash. The bake validates the settings once.
#pragma once

#include <string>

#include "host/formats/asset/representation.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

/// Fewest and most lobes per texel.
struct LobeCounts {
  int fewest, most;
};
LobeCounts lobe_counts();

struct MovmfSettings {
  Representation representation = Representation::kMovmf;  // type of lobe
  int lobe_count = 4;                                      // 1..8
  int iteration_count = 12;                                // maximum number of EM iterations per texel, 1..1000
  // The number of EM iterations for texels that cover more than kSamplesUnchunkedMax normals. The number is higher for
  // these texels, because every finer level inherits their errors.
  int iteration_count_coarse = 30;  // 1..1000
  int iteration_count_top = 60;     // iterations for the coarsest level, 1..1000
  // Number of passes over a level. In the first pass, the texels that are fitted first depend only on their parents. In
  // each further pass, every texel starts from its own lobes, and all its neighbours are already fitted.
  int pass_count = 2;  // 1..8
  // Maximum number of EM iterations per texel in each further pass, 1..1000. For coarse texels, the maximum is at least
  // a third of the iterations of their first pass.
  int refit_iterations = 6;
  // A texel stops early when no lobe's kappa or weight changes by more than this ratio, and no lobe turns by more than
  // this fraction of its width. If 0, texels never stop early. Coarse texels always run all iterations.
  float convergence_tolerance = 0.01f;  // 0..0.1
  CoarseNormals coarse_normals = CoarseNormals::kBinned;
  // After EM, refines each texel's lobes to reduce the error of their highlights (movmf_refine.cl). Applies only to
  // texels with binned normals, and only to representations whose lobes have a kappa.
  bool refine = false;
  FitOrder order = FitOrder::kColour;
  float alignment = 0.1f;    // C of the alignment prior, 0..10; 0 turns the prior off
  bool search_start = true;  // try the candidates for the coarsest level on a small proxy of the map
  // If true, for comparison, EM on the coarsest level starts only from the normals that are farthest apart.
  bool farthest_start = false;
  // True if the map repeats. Texels are then also aligned to texels across the border. bake_file() derives this setting
  // from the wrap modes.
  bool periodic_x = false;
  bool periodic_y = false;
  // The finest fitted level, 0..levels - 1. The result has no texels on finer levels. No level depends on a finer
  // level.
  int first_level = 0;
  bool aligned_start = true;  // if false, for comparison, texels start independently, so filtering mixes unrelated
                              // lobes
  // Upper limit of kappa (1/sigma^2 for Gaussians) inside EM: kappa_cap + kappa_cap_slope * (kappa of all normals of
  // the texel). The stored spread of a lobe does not depend on this limit.
  float kappa_cap = 500.0f;           // 1..1e5
  float kappa_cap_slope = 10.0f;      // 0..1000
  float start_kappa_factor = 0.5f;    // start kappa / kappa of the parent, 0.01..1
  float start_amplitude_min = 0.02f;  // minimum amplitude of a lobe at the start of EM, 0..0.125

  bool operator==(const MovmfSettings&) const = default;
};

/// Applies the given values of bake_parameters() to the settings, `reference` and `unaligned` first.
void apply(const ParameterValues& values, MovmfSettings& settings);

/// Sets the reference with which the default settings are compared. It uses every normal at every level, 30 iterations,
/// 10 iterations in further passes, and no early stop (docs/contributing/ALGORITHMS.md, "Fewer evaluations").
void make_reference(MovmfSettings& settings);

/// Makes the bake fit every texel independently and without alignment, as in figures 5 and 6 of Tan et al. 2005. This
/// is for comparison only.
void make_unaligned(MovmfSettings& settings);

/// Throws Error(kUsage) that names the setting, its value and its range.
void validate(const MovmfSettings& settings);

/// Returns every setting that changes pixels, as JSON with sorted keys. The file's settings hash is the hash of this
/// text.
std::string settings_json(const MovmfSettings& settings);

}  // namespace multum
