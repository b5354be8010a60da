// SPDX-License-Identifier: Apache-2.0
// Collects what a scene requires of one of its maps. These requirements do not depend on the contents of the map.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/bakes/scene/lobe_errors.h"
#include "host/bakes/scene/scene_file.h"

namespace multum {

/// The requirements of the materials of all objects that show a map.
struct MapNeeds {
  bool diffuse = false, specular = false;
  bool width_in_map = false, weighted = false;
  bool environment_highlight = false, takes_vmf = false;  // takes_vmf is true for BRDFs that are sums of vMFs
  double exponent_min = 0.0, exponent_max = 0.0;          // range of exponents of the highlights that have one
  int first_seen = 0, last_seen = 0;
  std::vector<ShadedBy> diffuse_by, highlights_by;

  void add_diffuse(int weight) {
    diffuse = true;
    add(diffuse_by, {std::nullopt, weight});
  }
  void add_highlight(double exponent, int weight) {
    specular = true;
    add(highlights_by, {exponent, weight});
    if (!std::isfinite(exponent)) return;
    const bool is_first = exponent_max == 0.0;
    exponent_min = is_first ? exponent : std::min(exponent_min, exponent);
    exponent_max = is_first ? exponent : std::max(exponent_max, exponent);
  }
  // Returns the exponents of the sharpest and the broadest highlight, for which a bake measures errors. The list is
  // empty if the map contains the widths of highlights.
  std::vector<double> exponents() const {
    std::vector<double> ends;
    if (exponent_max > 0.0) ends.push_back(exponent_max);
    if (exponent_min < exponent_max) ends.push_back(exponent_min);
    return ends;
  }

 private:
  static void add(std::vector<ShadedBy>& all, const ShadedBy& one) {
    const auto is_one = [&](const ShadedBy& by) { return by.exponent == one.exponent && by.weight == one.weight; };
    if (std::none_of(all.begin(), all.end(), is_one)) all.push_back(one);
  }
};

/// `map` is an index into scene.maps. The map is `width` texels wide and has `level_count` levels.
MapNeeds needs_of(const SceneDescription& scene, std::size_t map, int width, int level_count);

}  // namespace multum
