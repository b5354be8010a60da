// SPDX-License-Identifier: Apache-2.0
// Holds the settings of a fit of lobes. Ranges, and the names that people and the settings hash know them by, are rows
// of bake_parameters(). Validated once, by the bake.
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
  Representation representation = Representation::kMovmf;  // of lobes: what a lobe is
  int lobe_count = 4;                                      // 1..8
  int iteration_count = 12;                                // EM iterations a texel, at most; 1..1000
  // Of texels that cover more than kSamplesUnchunkedMax normals: what they miss every finer level misses.
  int iteration_count_coarse = 30;  // 1..1000
  int iteration_count_top = 60;     // of the coarsest level, 1..1000
  // After a level is fitted, it is fitted again this many times less one, each texel from its own lobes with all its
  // neighbours done: what was fitted first has by then seen only its parent.
  int pass_count = 2;  // 1..8
  // EM iterations per texel in each further pass, at most; 1..1000. Coarse texels run a third of theirs if that is
  // more.
  int refit_iterations = 6;
  // A texel is done before when no lobe's kappa or weight changes by more than this share, and none turns by more than
  // this share of its width; 0: never. Coarse texels run all their iterations.
  float convergence_tolerance = 0.01f;  // 0..0.1
  CoarseNormals coarse_normals = CoarseNormals::kBinned;
  // After EM each texel's lobes are refined towards the highlights that they give (movmf_refine.cl). Of lobes with a
  // kappa and binned normals alone.
  bool refine = false;
  FitOrder order = FitOrder::kColour;
  float alignment = 0.1f;    // C of the alignment prior, 0..10; 0: none
  bool search_start = true;  // try the coarsest level's candidates on a small proxy map of the map
  // The coarsest level starts from normals that lie farthest apart, and from nothing else: for comparison.
  bool farthest_start = false;
  // The map repeats: texels are held to those beyond the border as well. bake_file() sets them by its wrap modes.
  bool periodic_x = false;
  bool periodic_y = false;
  // The finest level that is fitted, 0..levels - 1; no level depends on a finer one. The result has those finer than
  // this without texels.
  int first_level = 0;
  bool aligned_start = true;  // false: every texel starts by itself (for comparison: filtering then mixes lobes up)
  // Cap of kappa (1/sigma^2 of Gaussians) inside EM: kappa_cap + kappa_cap_slope * kappa of all the texel's normals
  // (what a lobe stores is its normals' own spread, whatever the cap).
  float kappa_cap = 500.0f;           // 1..1e5
  float kappa_cap_slope = 10.0f;      // 0..1000
  float start_kappa_factor = 0.5f;    // kappa of a start is the parent's times this, 0.01..1
  float start_amplitude_min = 0.02f;  // and its amplitude at least this, 0..0.125

  bool operator==(const MovmfSettings&) const = default;
};

/// What was given replaces what `settings` hold, `reference` and `unaligned` first. `values` are of bake_parameters().
void apply(const ParameterValues& values, MovmfSettings& settings);

/// Sets what the defaults are measured against: every normal at every level, 30 iterations and 10 in further passes,
/// none cut short (docs/contributing/ALGORITHMS.md, "Fewer evaluations").
void make_reference(MovmfSettings& settings);

/// Fits every texel by itself, without alignment: for comparison alone (Tan et al. 2005, figures 5 and 6).
void make_unaligned(MovmfSettings& settings);

/// Throws Error(kUsage) naming the setting, its value and its range.
void validate(const MovmfSettings& settings);

/// Every setting that changes pixels, as JSON with sorted keys: the text behind the file's settings hash.
std::string settings_json(const MovmfSettings& settings);

}  // namespace multum
