// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/map_needs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/bakes/scene/seen_levels.h"
#include "host/formats/brdf/facet_distribution.h"

namespace multum {
namespace {

bool is_black(const glm::vec3& colour) { return colour == glm::vec3(0.0f); }

// `weight` is the index of the map's weight that blends the material, or -1 if there is none.
void add_material(const SceneDescription& scene, const SceneMaterial& material, int weight, MapNeeds& needs) {
  needs.width_in_map |= material.width_in_map;
  for (const Brdf& brdf : material.brdfs) {
    if (!is_black(brdf.diffuse)) needs.add_diffuse(weight);
    if (!has_highlight(brdf)) continue;
    needs.add_highlight(material.width_in_map ? std::numeric_limits<double>::infinity() : equivalent_exponent(brdf),
                        weight);
    needs.environment_highlight |= !scene.environment.empty();
    needs.takes_vmf |= is_vmf_sum(brdf);
  }
}

}  // namespace

MapNeeds needs_of(const SceneDescription& scene, std::size_t map, int width, int level_count) {
  MapNeeds needs;
  bool is_first = true;
  for (const SceneObject& object : scene.objects) {
    if (object.map != map) continue;
    const SeenLevels seen = seen_levels(scene.camera, object, width, level_count);
    needs.first_seen = is_first ? seen.first : std::min(needs.first_seen, seen.first);
    needs.last_seen = is_first ? seen.last : std::max(needs.last_seen, seen.last);
    is_first = false;
    needs.weighted |= object.materials.size() > 1;
    for (std::size_t k = 0; k < object.materials.size(); ++k)
      add_material(scene, scene.materials[object.materials[k]], object.materials.size() > 1 ? static_cast<int>(k) : -1,
                   needs);
  }
  return needs;
}

}  // namespace multum
