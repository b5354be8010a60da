// SPDX-License-Identifier: Apache-2.0
// Says what became of a material's normals and what pictures said of it, in a line and for a report.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/delivery/forms/material_forms.h"

namespace multum {

struct ChosenForm {
  NormalForm normals;
  bool has_lobes = false, has_lobe_colours = false;
  // Relative L1 errors in per cent, by view; empty where none were drawn.
  std::vector<FormView> views;
  std::map<std::string, FormError> errors;  // "plain", "one_lobe", "chosen"; of 4 evaluations "points_4", "lobes_4"; in
                                            // colour "mean_colour_4", "lobe_colours_4"
  bool is_on_sphere = false;                // for want of a mesh that can be drawn

  /// "at 12 m plain 13.1 %, one lobe 12.9 %; with 4 evaluations points 11.0 %, lobes 10.9 %: fitted normals and
  /// roughness, with lobes". `has_own_maps`: what is not chosen stays as it was, rather than being written.
  std::string to_text(bool has_own_maps) const;
  /// {"distances", "shapes", "errors": {"plain": [...]}, "levels": [{"fitted_normals", "fitted_roughness"}], "lobes",
  /// "lobe_colours", "on_sphere"}; "shapes" where there is no model.
  nlohmann::ordered_json to_json() const;
};

}  // namespace multum
