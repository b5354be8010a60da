// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/job_parameters.h"

#include <fmt/format.h>

#include <cstdio>

#include "host/formats/image/normals/reading_parameters.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

// In this case, level 0 would be the normal map itself, which does not contain points of the interpolated surface.
void apply_surface(const ParameterValues& values, BakeJob& job) {
  job.surface = map_surface(values).value_or(job.surface);
  if (job.surface == MapSurface::kTexels || job.fitting.first_level > 0) return;
  if (values.integer("first_level"))
    throw Error(ErrorCode::kUsage,
                "--first-level is 0 with --surface interpolated, expected 1 or more, because level 0 would store "
                "points between the texels instead of the texels");
  job.fitting.first_level = 1;
}

bool is_in_scope(const Parameter& parameter, Representation representation) {
  switch (parameter.scope) {
    case ParameterScope::kAll: return true;
    case ParameterScope::kLobes: return holds_lobes(representation);
    case ParameterScope::kHarmonics: return representation_info(representation).has_order;
  }
  return true;
}

}  // namespace

ParameterValues bake_values(std::initializer_list<std::pair<const char*, ParameterValue>> values) {
  ParameterValues all(bake_parameters());
  for (const auto& [name, value] : values) all.set(name, value);
  return all;
}

void apply(const ParameterValues& values, BakeJob& job) {
  apply_reading(values, job.reading);
  if (const auto file = values.text("albedo")) job.albedo = *file;
  if (const auto file = values.text("roughness")) job.roughness = *file, job.roughness_is_gloss = false;
  if (const auto file = values.text("gloss")) job.roughness = *file, job.roughness_is_gloss = !file->empty();
  if (const auto file = values.text("weights")) job.weights = *file;
  job.representation = given_representation(values).value_or(job.representation);
  apply(values, job.fitting);
  apply_surface(values, job);
  job.sh_order = values.integer("sh_order").value_or(job.sh_order);
  job.encoding = values.choice("data_format", kStorageEncodings)
                     .value_or(representation_info(job.representation).encodings.front());
  job.writing.compression = values.text("compression").value_or(job.writing.compression);
  if (const auto bytes = values.bytes("memory")) job.memory_bytes = static_cast<std::uint64_t>(*bytes);
  if (values.flag("no_measure")) job.measure = false;
  job.report = values.text("report").value_or(job.report);
  job.scratch_folder = values.text("scratch").value_or(job.scratch_folder);
  job.onto = values.text("onto").value_or(job.onto);
  if (values.flag("resume")) job.resume = true;
  if (values.flag("force")) job.force = true;
}

void apply_region(const ParameterValues& values, BakeJob& job) {
  if (values.has("region") != values.has("onto"))
    throw Error(ErrorCode::kUsage,
                "found only one of --region and --onto, expected both: --region names the edited part, and --onto "
                "names the file that was baked before");
  const std::string text = values.text("region").value_or("auto");
  if (text.empty() || text == "auto") return;
  MapRegion region;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &region.x, &region.y, &region.width, &region.height, &rest) != 4)
    throw Error(ErrorCode::kUsage,
                "--region is '" + text + "', expected auto, or x,y,width,height in texels, such as 0,256,128,64");
  job.region = region;
}

std::optional<Representation> given_representation(const ParameterValues& values) {
  return values.choice("ndf", kRepresentations);
}

const Parameter* given_of_target(const ParameterValues& values) {
  for (const Parameter& row : bake_parameters().rows())
    if (row.chosen_by_target && values.is_given(row.name)) return &row;
  return nullptr;
}

ParameterValues without_those_of_target(ParameterValues values) {
  for (const Parameter& row : bake_parameters().rows())
    if (row.chosen_by_target) values.erase(row.name);
  return values;
}

std::string options_text(const ParameterValues& values) { return values.options_text({kStorageGroup, kFitGroup}); }

const Parameter* given_of_another_ndf(const ParameterValues& values) {
  const Representation representation = given_representation(values).value_or(default_representation());
  for (const Parameter& row : bake_parameters().rows())
    if (values.is_given(row.name) && !is_in_scope(row, representation)) return &row;
  return nullptr;
}

std::string scope_text(const Parameter& parameter) {
  std::string text;
  for (const RepresentationInfo& info : representations())
    if (is_in_scope(parameter, info.representation)) text += (text.empty() ? "" : " and ") + std::string(info.option);
  return text;
}

void check_scopes(const ParameterValues& values) {
  const Parameter* const row = given_of_another_ndf(values);
  if (row == nullptr) return;
  const bool is_of_lobes = row->scope == ParameterScope::kLobes;
  throw Error(ErrorCode::kUsage,
              fmt::format("{} works only with --ndf {}, found --ndf {}{}", row->option(), scope_text(*row),
                          values.text("ndf").value_or(representations().front().option),
                          is_of_lobes ? ", which fits no lobes" : ""));
}

}  // namespace multum
