// SPDX-License-Identifier: Apache-2.0
// Holds the levels of a fitted material in memory or on disk until their form is chosen. Each texel has a mean and a
// fitted normal, and a mean and a fitted roughness (host/delivery/forms/material_forms.h).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/delivery/export/one_lobe_fit.h"
#include "host/delivery/forms/material_forms.h"
#include "host/delivery/forms/texture_lookups.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/size_of.h"

namespace multum {

class HeldMaterial : public MaterialSink {
 public:
  /// `inputs` must outlive this object, and must ask for means. If `has_unit_means` is true, means are held as unit
  /// vectors. Level 0 is passed on to `finest`, which may be null.
  HeldMaterial(const OneLobeInputs& inputs, const OneLobeSettings& settings, bool has_unit_means,
               const SpillPolicy& spill, MaterialSink* finest);

  void add_level(int level, int first_row, MaterialRows rows) override;

  /// Averages perceptual roughness, as a renderer does, if a map has roughness. Call this function once, after all rows
  /// have arrived and before textures().
  void average_roughness();

  struct Textures {
    std::unique_ptr<SharesTexture> averages, normals, surface;
    bool has_metalness = false;

    /// `metalness` applies to the whole surface, or multiplies the metalness map. `colour` is the base colour.
    FormTextures form_textures(double metalness, double colour) const {
      return {averages.get(), normals.get(), surface.get(), metalness, colour, has_metalness};
    }
  };
  /// Returns textures that read the held levels. This object must outlive them. Without a map, metalness is 1.
  Textures textures() const;

  /// Passes levels 1 and coarser on, in a form.
  void pass(const NormalForm& form, MaterialSink& sink, Progress* progress) const;

 private:
  struct Level {
    PlaneStore normals, means, values;    // `values` holds fitted roughness, mean roughness without normals, and
                                          // occlusion
    std::optional<PlaneStore> metalness;  // stored three times
  };

  Level& level_at(int level) { return levels_[size_of(level - 1)]; }
  const Level& level_at(int level) const { return levels_[size_of(level - 1)]; }
  double finest_roughness(int x, int y) const;
  glm::dvec4 average_at(int level, int x, int y) const;
  glm::dvec4 surface_at(int level, int x, int y) const;
  void average_rows(int level, int first, int count);
  MaterialRows formed_rows(const LevelForm& form, int level, int first_row, int row_count) const;

  const OneLobeInputs& inputs_;
  MaterialSink* const finest_;
  const bool has_unit_means_;
  const float base_;  // perceptual; used without a roughness map
  const TextureFrame frame_;
  std::vector<Level> levels_;  // from 1 on
};

}  // namespace multum
