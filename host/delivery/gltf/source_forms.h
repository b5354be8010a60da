// SPDX-License-Identifier: Apache-2.0
// Chooses the form of a LobeSource's textures by pictures of the model (host/delivery/forms/material_forms.h).
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/delivery/forms/material_forms.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/delivery/gltf/source_fit.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// What is made of a source.
struct SourceForm {
  NormalForm normals;
  bool has_lobes = false, has_lobe_colours = false;
  // Relative L1 errors in per cent, by distance; empty where none were drawn.
  std::vector<double> distances;
  std::map<std::string, FormError> errors;  // "plain", "one_lobe", "chosen"; of 4 evaluations "points_4", "lobes_4"; in
                                            // colour "mean_colour_4", "lobe_colours_4"
  bool is_on_sphere = false;                // for want of a mesh that can be drawn

  /// "at 12 m plain 13.1 %, one lobe 12.9 %; with 4 evaluations points 11.0 %, lobes 10.9 %: lobes".
  std::string to_text() const;
  /// {"distances", "errors": {"plain": [...]}, "levels": [{"fitted_normals", "fitted_roughness"}], "lobes",
  /// "on_sphere"}
  GltfJson to_json() const;
};

/// Draws the model when it is first asked, once for all sources with the same set of texture coordinates.
class SourceForms {
 public:
  /// Both must outlive it.
  SourceForms(const GltfAsset& asset, const GltfPlan& plan, const SourceFitSettings& settings, Progress* progress);
  ~SourceForms();

  /// `baked`: a file of the source's lobes, which are a candidate; empty: they are none.
  SourceForm choose(std::size_t source, const FittedSource& fitted, const std::string& baked);

 private:
  struct Drawn;
  const Drawn& drawn(std::uint64_t uv_set);

  const GltfAsset& asset_;
  const GltfPlan& plan_;
  const SourceFitSettings settings_;
  Progress* const progress_;
  std::map<std::uint64_t, std::unique_ptr<Drawn>> drawn_;  // by set
};

/// Writes what a form takes from averages over levels from 1 on of the fitted ones.
void apply_normal_form(const NormalForm& form, FittedSource& fitted);

}  // namespace multum
