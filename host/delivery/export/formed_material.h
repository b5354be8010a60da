// SPDX-License-Identifier: Apache-2.0
// Fits a material and gives each of its levels the form that pictures of simple shapes ask for
// (host/delivery/forms/material_forms.h): the mean of normals or the fitted one, with as much of the fitted roughness.
#pragma once

#include <optional>

#include "host/delivery/export/one_lobe_fit.h"
#include "host/delivery/forms/chosen_form.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

struct FormSettings {
  MaterialForm form = MaterialForm::kOneLobe;
  Engine engine = Engine::kThree;  // whose pictures choose, of MaterialForm::kAuto
  bool has_two_channels = false;   // of stored normals x and y alone: means are stored as unit vectors
  SpillPolicy spill;               // of levels from 1 on, which wait for their form: up to four stores each
};

struct FormedReport {
  OneLobeReport fit;
  std::optional<ChosenForm> form;  // of MaterialForm::kAuto
};

/// As fit_one_lobe(), which it is for MaterialForm::kOneLobe. Anisotropic lobes have no other form.
FormedReport fit_formed_material(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                                 const FormSettings& form, MaterialSink& sink, Progress* progress);

}  // namespace multum
