// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/map_options.h"

#include <fmt/format.h>

#include "tools/command_line/choices.h"
#include "tools/command_line/reading_options.h"

namespace multum {
namespace {

template <typename Value>
std::string name_of(const Choices<Value>& choices, Value value) {
  for (const auto& [name, meaning] : choices)
    if (meaning == value) return name;
  return "";
}

// Defaults are shown, not filled in: --reference changes what is not given.
template <typename Value>
void add_choice_with_default(CLI::App& bake, const std::string& option, std::optional<Value>& value,
                             const Choices<Value>& choices, Value usual, const std::string& help) {
  add_choice(bake, option, value, choices, help)->default_str(name_of(choices, usual));
}

void add_fit_options(CLI::App& bake, MapOptions& o) {
  const MovmfSettings usual;
  const auto add = [&](const char* option, auto& value, const auto& usual_value, const char* help) {
    bake.add_option(option, value, help)->default_str(fmt::format("{}", usual_value));
  };
  add("--lobes", o.lobes, usual.lobe_count,
      "of vmf and gmm, as are the options of the fit below: lobes a texel, 1..8; more are larger, slower and usually "
      "more accurate");
  bake.add_flag("--reference", o.reference,
                "every normal at every level, 30 iterations, none cut short: what the defaults are measured against, "
                "slower");
  add("--iterations", o.iterations, usual.iteration_count, "EM iterations a texel, at most");
  add("--sweeps", o.sweeps, usual.sweep_count, "times that a level is fitted; more than one aligns it better");
  add_choice_with_default(bake, "--order", o.order, kFitOrders, usual.order,
                          "colour (parallel) or scanline (the paper's)");
  add_choice_with_default(bake, "--coarse-normals", o.coarse_normals, kCoarseNormals, usual.coarse_normals,
                          "what EM sees of coarse texels: all, or condensed (cells of like normals: faster)");
  bake.add_flag("--no-rehearsal", o.no_rehearsal,
                "start from the candidate of least error, without trying them all: saves half a second");
  bake.add_flag("--unaligned", o.unaligned,
                "every texel's lobes by themselves, for comparison: filtering then mixes them up");
  add("--align", o.alignment, usual.alignment, "weight of the alignment prior; 0: none");
  add("--kappa-cap", o.kappa_cap, usual.kappa_cap,
      "sharpest lobe that EM uses on rough texels; smooth ones get sharper ones");
}

// "vmf: lobes (Han 2007), the most accurate; moments: ...", the default first.
std::string ndf_help() {
  std::string text = "what texels hold. ";
  for (const RepresentationInfo& info : representations())
    text += fmt::format("{}{}: {}", &info == &representations().front() ? "" : "; ", info.option, info.help);
  return text;
}

void add_storage_options(CLI::App& bake, MapOptions& o) {
  const BakeJob usual;
  add_choice_with_default(bake, "--ndf", o.ndf, kNdfs, usual.representation, ndf_help());
  bake.add_option("--sh-order", o.sh_order,
                  fmt::format("of sh: spherical harmonics up to this l, {}..{}; order 4 is for diffuse, 8 for broad "
                              "highlights (docs/ALGORITHMS.md)",
                              kShOrderMin, kShOrderMax))
      ->default_str(fmt::format("{}", usual.sh_order));
  bake.add_option("--first-level", o.first_level,
                  "finest level to store; renderers take finer ones from the normal map (docs/FORMAT.md)")
      ->default_str(fmt::format("{}", usual.fitting.first_level));
  add_choice_with_default(bake, "-d,--data-format", o.data_format, kStorageEncodings, usual.encoding,
                          "what is stored is rounded to; half loses kappa above 1000 of lobes, and is the default of "
                          "moments and sh (docs/FORMAT.md)");
  bake.add_option("--compression", o.compression, "none, rle, zips, zip or piz, zip:1..9")
      ->default_str(usual.writing.compression);
}

void add_input_options(CLI::App& bake, MapOptions& o) {
  const NormalMapSettings usual;
  o.reading.bump_format = usual.bump_format;  // --help shows these as the defaults
  o.reading.height_scale = usual.height_scale;
  o.reading.normal_scale = usual.normal_scale;
  o.reading.fix_nan = usual.fix_nan;
  o.reading.repair_share_max = usual.repair_share_max;
  add_reading_options(bake, o.reading);
  add_choice(
      bake, "--wrap", o.wrap, kMapWraps,
      "beyond the border: black, clamp, periodic, mirror, or auto: periodic where the map tiles, else clamp (default: "
      "periodic)");
  add_choice(bake, "--swrap", o.wrap_s, kMapWraps, "the same for s (x) alone");
  add_choice(bake, "--twrap", o.wrap_t, kMapWraps, "the same for t (y) alone");
  bake.add_flag("--checknan", o.check_nan, "refuse a file with NaN or Inf, naming the first");
  bake.add_option("--albedo", o.albedo, "colour map of the same size: bakes colours, per lobe or averaged");
  CLI::Option* const roughness = bake.add_option(
      "--roughness", o.roughness,
      "FILE or FILE:CHANNEL, perceptual roughness 0 to 1 of the same size (default: the only channel, or G): "
      "bakes the BRDF's width into the lobes, so that none is chosen when they are drawn");
  bake.add_option("--gloss", o.gloss, "the same of a gloss map: FILE or FILE:CHANNEL, roughness = 1 - gloss")
      ->excludes(roughness);
  bake.add_option("--weights", o.weights,
                  "map of the same size, 1 to 4 channels of 0 to 1: weights of as many basis BRDFs, per lobe or "
                  "averaged");
}

}  // namespace

void add_map_options(CLI::App& bake, MapOptions& options) {
  const std::vector<CLI::Option*> before = bake.get_options();
  add_storage_options(bake, options);
  add_fit_options(bake, options);
  add_input_options(bake, options);
  const std::vector<CLI::Option*> after = bake.get_options();
  for (std::size_t i = before.size(); i < after.size(); ++i) after[i]->group(kMapOptionGroup);
}

}  // namespace multum
