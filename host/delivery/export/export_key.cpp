// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/export_key.h"

#include <nlohmann/json.hpp>
#include <optional>

#include "host/formats/image/material_maps.h"
#include "host/formats/opencl/program_cache.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

using Json = nlohmann::json;

// Returns the value of an optional, or null.
template <typename Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

}  // namespace

Json fit_key(const ExportJob& job, const std::function<std::string(const std::string&)>& hash) {
  const NormalMapSettings& reading = job.reading;
  Json key = {{"software", software_version()},
              {"kernels", kernel_sources_hash()},
              {"reading",
               {reading.bump_format, json_of(reading.green), json_of(reading.is_signed), json_of(reading.two_channel),
                json_of(reading.z_range), reading.height_scale, reading.dequantize, reading.normal_scale,
                reading.wrap_s, reading.wrap_t, reading.wrap_s_origin, reading.wrap_t_origin, reading.fix_nan}},
              {"lobe",
               {job.lobe.is_anisotropic, job.lobe.is_fast,
                job.roughness.empty() ? Json(job.lobe.base_roughness) : Json(), job.lobe.iteration_count}},
              {"gloss", job.roughness_is_gloss}};
  if (reading.tiles != nullptr) key["tile"] = reading.tile;
  if (job.surface == MapSurface::kInterpolated) key["surface"] = map_surface_name(job.surface);
  ExportJob made_of = job;
  made_of.lobes.clear();  // lobes are used only for comparison
  for (const std::string& file : input_files(made_of)) key["inputs"].push_back(hash(file));
  // Adds the channel of each map.
  for (const std::string& named : {job.roughness, job.occlusion, job.metalness})
    key["channels"].push_back(named.empty() ? Json() : Json(parse_channel_file(named).channel));
  return key;
}

Json export_key(const ExportJob& job) {
  Json key = fit_key(job, hash_file);
  key["format"] = json_of(job.format);
  key["texels"] = json_of(job.texels);
  key["zstd"] = json_of(job.zstd_level);
  key["packing"] = choice_name(kMaterialPackings, job.packing);
  key["names"] = choice_name(kTextureNames, job.names);
  key["write_green"] = choice_name(kGreenAxes, job.write_green);
  if (const MaterialForm form = job.form.value_or(MaterialForm::kOneLobe); form != MaterialForm::kOneLobe)
    key["form"] = choice_name(kMaterialForms, form);
  if (job.engine) key["for"] = choice_name(kEngines, *job.engine);
  if (stored_texels(job) == MaterialTexels::kUastc) key["uastc_effort"] = job.uastc_effort;
  return key;
}

}  // namespace multum
