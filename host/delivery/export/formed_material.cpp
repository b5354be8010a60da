// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/formed_material.h"

#include <vector>

#include "host/delivery/export/held_material.h"
#include "host/delivery/forms/simple_views.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr double kColour = 0.5;  // assumed base colour, because exports have none

}  // namespace

ChosenForm choose_export_form(const FormTextures& textures, Engine engine, int threads, std::size_t pixels_per_view) {
  const TextureFrame& frame = textures.averages->frame();
  const std::vector<ModelPicture> seen = simple_views(frame.width, frame.height, pixels_per_view);
  const FormMeter meter(textures, seen, {engine, false, threads});
  ChosenForm made;
  made.views = meter.views();
  made.normals = NormalForm::of(frame.level_count, {true, 1.0});
  if (made.views.empty()) return made;
  const ChosenNormalForm chosen = choose_normal_form(meter, made.normals);
  made.normals = chosen.form;
  made.errors = {{"plain", chosen.plain}, {"one_lobe", chosen.fitted}, {"chosen", chosen.chosen}};
  return made;
}

FormedReport fit_formed_material(Device& device, const OneLobeInputs& inputs, const OneLobeSettings& settings,
                                 const FormSettings& form, MaterialSink& sink, Progress* progress) {
  if (form.form == MaterialForm::kOneLobe)
    return {fit_one_lobe(device, inputs, settings, sink, progress), std::nullopt};
  MULTUM_CHECK(!settings.is_anisotropic);
  OneLobeInputs with_means = inputs;
  with_means.wants_means = true;
  HeldMaterial held(with_means, settings, form.has_two_channels || filter_of(form.engine).rebuilds_z, form.spill,
                    &sink);
  FormedReport report{fit_one_lobe(device, with_means, settings, held, progress), std::nullopt};
  progress_stage(progress, "form");
  NormalForm normals = NormalForm::of(mip_level_count(inputs.normals->width(), inputs.normals->height()), {false, 1.0});
  if (form.form == MaterialForm::kAuto) {
    held.average_roughness();
    const HeldMaterial::Textures textures = held.textures();
    report.form = choose_export_form(textures.form_textures(inputs.has_metalness ? 1.0 : 0.0, kColour), form.engine,
                                     inputs.threads);
    normals = report.form->normals;
  }
  held.pass(normals, sink, progress);
  return report;
}

}  // namespace multum
