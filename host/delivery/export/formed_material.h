// SPDX-License-Identifier: Apache-2.0
// Fits a material and gives each level the form that is best in pictures of simple shapes
// (host/delivery/forms/material_forms.h). A form uses mean or fitted normals, and a share of the fitted roughness.
#pragma once

#include <optional>

#include "host/delivery/export/one_lobe_fit.h"
#include "host/delivery/forms/chosen_form.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

struct FormSettings {
  MaterialForm form = MaterialForm::kOneLobe;
  Engine engine = Engine::kThree;  // engine whose pictures choose the form, for MaterialForm::kAuto
  bool has_two_channels = false;   // true if textures store only x and y of normals; means are then stored as unit
                                   // vectors
  // The storage of levels 1 and coarser until their form is chosen. Each level uses up to four stores.
  SpillPolicy spill;
};

struct FormedReport {
  OneLobeReport fit;
  std::optional<ChosenForm> form;  // set only for MaterialForm::kAuto
};

constexpr std::size_t kFormPixels = 140;  // per view, for choose_export_form()

/// Chooses the form of an export by pictures of simple shapes. If a map is too small for pictures, returns fitted
/// levels and no errors.
ChosenForm choose_export_form(const FormTextures& textures, Engine engine, int threads,
                              std::size_t pixels_per_view = kFormPixels);

/// Does the same as fit_one_lobe() for MaterialForm::kOneLobe. Anisotropic lobes allow no other form.
FormedReport fit_formed_material(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                                 const FormSettings& form, MaterialSink& sink, Progress* progress);

}  // namespace multum
