// SPDX-License-Identifier: Apache-2.0
#include "host/bake/map_options.h"

#include <fmt/format.h>

#include <utility>

#include "host/base/error.h"

namespace multum {
namespace {

void apply_to_fit(const MapOptions& o, MovmfSettings& fit) {
  if (o.reference) make_reference(fit);
  if (o.unaligned) make_unaligned(fit);
  if (o.lobes) fit.lobe_count = *o.lobes;
  if (o.iterations) fit.iteration_count = fit.iteration_count_coarse = *o.iterations;
  if (o.sweeps) fit.sweep_count = *o.sweeps;
  if (o.order) fit.order = *o.order;
  if (o.coarse_normals) fit.coarse_normals = *o.coarse_normals;
  if (o.no_rehearsal) fit.rehearse_start = false;
  if (o.alignment) fit.alignment = *o.alignment;
  if (o.kappa_cap) fit.kappa_cap = *o.kappa_cap;
  if (o.first_level) fit.first_level = *o.first_level;
}

// Any of auto, which the map decides.
WrapMode mode_of(MapWrap wrap) {
  switch (wrap) {
    case MapWrap::kBlack: return WrapMode::kBlack;
    case MapWrap::kClamp: return WrapMode::kClamp;
    case MapWrap::kMirror: return WrapMode::kMirror;
    case MapWrap::kAuto:
    case MapWrap::kPeriodic: return WrapMode::kPeriodic;
  }
  return WrapMode::kPeriodic;
}

WrapOrigin origin_of(MapWrap wrap) { return wrap == MapWrap::kAuto ? WrapOrigin::kFound : WrapOrigin::kSaid; }

}  // namespace

void set_wrap_s(MapWrap wrap, NormalMapSettings& settings) {
  settings.wrap_s = mode_of(wrap);
  settings.wrap_s_origin = origin_of(wrap);
}

void set_wrap_t(MapWrap wrap, NormalMapSettings& settings) {
  settings.wrap_t = mode_of(wrap);
  settings.wrap_t_origin = origin_of(wrap);
}

void apply(const MapOptions& o, BakeJob& job) {
  apply(o.reading, job.reading);
  if (o.check_nan) job.reading.check_nan = true;
  for (const auto& wrap : {o.wrap, o.wrap_s})
    if (wrap) set_wrap_s(*wrap, job.reading);
  for (const auto& wrap : {o.wrap, o.wrap_t})
    if (wrap) set_wrap_t(*wrap, job.reading);
  if (o.albedo) job.albedo = *o.albedo;
  if (o.roughness) job.roughness = *o.roughness, job.roughness_is_gloss = false;
  if (o.gloss) job.roughness = *o.gloss, job.roughness_is_gloss = !o.gloss->empty();
  if (o.weights) job.weights = *o.weights;
  if (o.ndf) job.representation = *o.ndf;
  apply_to_fit(o, job.fitting);
  if (o.sh_order) job.sh_order = *o.sh_order;
  job.encoding = o.data_format.value_or(representation_info(job.representation).encodings.front());
  if (o.compression) job.writing.compression = *o.compression;
}

const char* option_of_target(const MapOptions& o) {
  const std::pair<const char*, bool> chosen[] = {{"--lobes", o.lobes.has_value()},
                                                 {"--sh-order", o.sh_order.has_value()},
                                                 {"--reference", o.reference},
                                                 {"--iterations", o.iterations.has_value()},
                                                 {"--sweeps", o.sweeps.has_value()},
                                                 {"--no-rehearsal", o.no_rehearsal},
                                                 {"--data-format", o.data_format.has_value()},
                                                 {"--unaligned", o.unaligned}};
  for (const auto& [option, is_given] : chosen)
    if (is_given) return option;
  return nullptr;
}

MapOptions without_options_of_target(MapOptions o) {
  o.lobes.reset(), o.sh_order.reset(), o.iterations.reset(), o.sweeps.reset(), o.data_format.reset();
  o.reference = o.no_rehearsal = o.unaligned = false;
  return o;
}

std::string options_text(const MapOptions& o) {
  std::string text;
  const auto add = [&](const char* option, const auto& value) {
    if (value) text += fmt::format("{}{} {}", text.empty() ? "" : " ", option, *value);
  };
  const auto add_flag = [&](const char* option, bool is_given) {
    if (is_given) text += (text.empty() ? "" : " ") + std::string(option);
  };
  const auto add_choice = [&](const char* option, const auto& value, const auto& choices) {
    for (const auto& [name, meaning] : choices)
      if (value == meaning) add(option, std::optional(name));
  };
  add_choice("--ndf", o.ndf, kNdfs);
  add("--lobes", o.lobes);
  add("--sh-order", o.sh_order);
  add_flag("--reference", o.reference);
  add_flag("--unaligned", o.unaligned);
  add("--iterations", o.iterations);
  add("--sweeps", o.sweeps);
  add_flag("--no-rehearsal", o.no_rehearsal);
  add_choice("--order", o.order, kFitOrders);
  add_choice("--coarse-normals", o.coarse_normals, kCoarseNormals);
  add("--align", o.alignment);
  add("--kappa-cap", o.kappa_cap);
  add("--first-level", o.first_level);
  add_choice("--data-format", o.data_format, kStorageEncodings);
  add("--compression", o.compression);
  return text;
}

void check_options_of_ndf(const MapOptions& o) {
  const Representation representation = o.ndf.value_or(Representation::kMovmf);
  if (o.sh_order && representation != Representation::kSh)
    throw Error(ErrorCode::kUsage,
                fmt::format("--sh-order is for --ndf sh, found --ndf {}", representation_info(representation).option));
  if (holds_lobes(representation)) return;
  const std::pair<const char*, bool> options[] = {
      {"--lobes", o.lobes.has_value()},           {"--reference", o.reference},
      {"--iterations", o.iterations.has_value()}, {"--sweeps", o.sweeps.has_value()},
      {"--order", o.order.has_value()},           {"--coarse-normals", o.coarse_normals.has_value()},
      {"--no-rehearsal", o.no_rehearsal},         {"--align", o.alignment.has_value()},
      {"--kappa-cap", o.kappa_cap.has_value()},   {"--unaligned", o.unaligned}};
  for (const auto& [option, is_given] : options)
    if (is_given)
      throw Error(ErrorCode::kUsage, fmt::format("{} is for --ndf vmf and gmm, found --ndf {}, which fits no lobes",
                                                 option, representation_info(representation).option));
}

}  // namespace multum
