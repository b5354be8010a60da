// SPDX-License-Identifier: Apache-2.0
// Draws pictures of the model to choose the form of a LobeSource's textures (host/delivery/forms/material_forms.h).
#pragma once

#include <map>
#include <memory>
#include <string>

#include <glm/vec2.hpp>

#include "host/delivery/forms/chosen_form.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/delivery/gltf/source_fit.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// Factors of a glTF material: of its metalness, and of its base colour as grey. The values of a base colour texture
/// are assumed to be 0.5.
struct GltfFactors {
  double metalness = 1.0, grey = 1.0;
};
GltfFactors gltf_factors(const GltfJson& material);

/// Applies KHR_texture_transform. v grows upwards in meshes, but downwards in glTF.
glm::dvec2 place_in_image(const TextureCoordinates& coordinates, const glm::dvec2& uv);

/// The model is drawn on first use, once for all sources with the same set of texture coordinates.
class SourceForms {
 public:
  /// Both `asset` and `plan` must outlive this object. The pictures use the filter of `engine`.
  SourceForms(const GltfAsset& asset, const GltfPlan& plan, const SourceFitSettings& settings, Engine engine,
              Progress* progress);
  ~SourceForms();

  /// `baked` is the file of the source's lobes, which are then one of the candidates. If there are no lobes, `baked` is
  /// empty.
  ChosenForm choose(std::size_t source, const FittedSource& fitted, const std::string& baked);

 private:
  struct Drawn;
  const Drawn& drawn(std::uint64_t uv_set);

  const GltfAsset& asset_;
  const GltfPlan& plan_;
  const SourceFitSettings settings_;
  const Engine engine_;
  Progress* const progress_;
  std::map<std::uint64_t, std::unique_ptr<Drawn>> drawn_;  // by set of texture coordinates
};

/// Replaces fitted values with averages in levels 1 and coarser, as the form requires.
void apply_normal_form(const NormalForm& form, FittedSource& fitted);

}  // namespace multum
