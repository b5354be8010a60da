// SPDX-License-Identifier: Apache-2.0
// Describes the form of a material's normals and the errors of this form in pictures, as one line of text and as a
// report.
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
  // Relative L1 errors in percent, by view. Empty if no pictures were drawn.
  std::vector<FormView> views;
  std::map<std::string, FormError> errors;  // keys: "plain", "one_lobe", "chosen"; with 4 evaluations "points_4",
                                            // "lobes_4"; in colour "mean_colour_4", "lobe_colours_4"
  bool is_on_sphere = false;                // true if drawn on a sphere because no mesh could be drawn

  /// Returns text such as "at 12 m: plain mips 13.1 %, export 12.9 %, with 4 evaluations 11.0 %, lobes 10.9 %; fitted
  /// normals and roughness, with lobes". Lobes have 4 evaluations, too. If `has_own_maps` is true, the text says that
  /// parts that are not chosen keep the material's own maps.
  std::string to_text(bool has_own_maps) const;
  /// Returns {"distances", "shapes", "errors": {"plain": [...]}, "levels": [{"fitted_normals", "fitted_roughness"}],
  /// "lobes", "lobe_colours", "on_sphere"}. "shapes" is present only if there is no model.
  nlohmann::ordered_json to_json() const;
};

}  // namespace multum
