// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/bake_parameters.h"

#include <utility>

#include "host/foundation/brdf_families/brdf_forms.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/shared_parameters.h"

namespace multum {
namespace {

using Kind = ParameterKind;
using Rows = std::vector<Parameter>;

constexpr unsigned kJob = kOnCommandLine | kInManifest | kInService;
constexpr double kLeastMemory = 288.0 * (1 << 20);  // the program's own 280 MiB and a window of 8 (bake_job.cpp)

void add(Rows& rows, Rows more, const char* group) {
  for (Parameter& row : more) {
    row.group = group;
    rows.push_back(std::move(row));
  }
}

Rows source_rows() {
  Rows rows = {
      {.name = "bumpformat",
       .kind = Kind::kChoice,
       .help =
           "kind of map; auto: detected from its statistics; packed16 and after: heights whose bytes are spread over "
           "red, green and blue",
       .default_text = "auto",
       .choices = choice_names(kBumpFormats),
       .hashed_as = "bump_format",
       .surfaces = kEverywhere},
      {.name = "green",
       .kind = Kind::kChoice,
       .help = "direction of green: up (OpenGL) or down (DirectX)",
       .default_text = "detected",
       .choices = choice_names(kGreenAxes),
       .hashed_as = "green",
       .surfaces = kEverywhere},
      {.name = "signed",
       .help = "read channel values as the vector itself, -1 to 1",
       .default_text = "detected",
       .hashed_as = "signed",
       .excludes = {"unsigned"},
       .surfaces = kEverywhere},
      {.name = "unsigned",
       .help = "read channel values as encoded, 0 to 1",
       .default_text = "detected",
       .hashed_as = "signed",
       .excludes = {"signed"},
       .surfaces = kEverywhere},
      two_channel_parameter(kEverywhere),
      z_range_parameter(kEverywhere),
      {.name = "height_scale",
       .kind = Kind::kNumber,
       .help = "height of a value difference of 1 in a height field; negative: dents become bumps",
       .low = -kUnbounded,
       .high = kUnbounded,
       .zero_excluded = true,
       .unit = "texels",
       .default_text = "1",
       .hashed_as = "height_scale",
       .surfaces = kEverywhere},
      {.name = "dequantize",
       .help = "of heights of 8 bits, take the smoothest that round to them: terraces become slopes, steps of two "
               "codes and more stay",
       .hashed_as = "dequantize",
       .surfaces = kEverywhere},
      {.name = "normal_scale",
       .kind = Kind::kNumber,
       .help = "factor of x and y of a normal map, as glTF's normalTexture.scale",
       .low = -kUnbounded,
       .high = kUnbounded,
       .default_text = "1",
       .hashed_as = "normal_scale",
       .surfaces = kEverywhere},
      {.name = "fixnan",
       .kind = Kind::kChoice,
       .help = "repair of NaN and Inf: none (refuse the file), black (flat) or box3 (mean of the neighbours)",
       .default_text = "box3",
       .choices = choice_names(kFixNans),
       .hashed_as = "fixnan",
       .surfaces = kEverywhere},
      {.name = "repair_max",
       .kind = Kind::kNumber,
       .help = "refuse a file that needs more repairs than this share of its texels",
       .low = 0.0,
       .high = 1.0,
       .default_text = "0.01",
       .surfaces = kEverywhere},
      {.name = "checknan", .help = "refuse a file with NaN or Inf, naming the first", .surfaces = kEverywhere}};
  for (Parameter& row : wrap_parameters(true, "periodic", kEverywhere)) rows.push_back(std::move(row));
  return rows;
}

Rows material_rows() {
  return {{.name = "albedo",
           .kind = Kind::kFile,
           .help = "bake the colours of this map of the same size, per lobe or averaged",
           .hashed_as = "albedo",
           .surfaces = kEverywhere},
          {.name = "roughness",
           .kind = Kind::kFile,
           .help = "bake the perceptual roughness, 0 to 1, of this map of the same size into the lobes: they then have "
                   "the width of the highlight, and no BRDF is chosen to draw them",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"gloss"},
           .surfaces = kEverywhere},
          {.name = "gloss",
           .kind = Kind::kFile,
           .help = "bake the gloss of this map instead of --roughness: roughness = 1 - gloss",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"roughness"},
           .surfaces = kEverywhere},
          {.name = "weights",
           .kind = Kind::kFile,
           .help = "bake the weights of 1 to 4 basis BRDFs, a channel of 0 to 1 each of this map of the same size, per "
                   "lobe or averaged",
           .hashed_as = "weights",
           .surfaces = kEverywhere}};
}

Rows representation_rows() {
  return {{.name = "ndf",
           .kind = Kind::kChoice,
           .help = "representation of the normals. vmf: lobes (Han 2007), the most accurate; moments: slopes and their "
                   "squares (LEAN); "
                   "gmm: planar Gaussians (Tan 2005); sh: spherical harmonics",
           .default_text = "vmf",
           .choices = choice_names(kRepresentations),
           .hashed_as = "representation",
           .surfaces = kJob},
          {.name = "sh_order",
           .kind = Kind::kInteger,
           .help = "highest order l of the harmonics: 4 for diffuse light, 8 for broad highlights",
           .low = 1,
           .high = 20,
           .default_text = "4",
           .hashed_as = "sh_order",
           .scope = ParameterScope::kHarmonics,
           .chosen_by_target = true,
           .surfaces = kJob}};
}

Rows storage_rows() {
  Parameter surface = surface_parameter("; its level 0 is the normal map (--first-level 1)", kJob);
  surface.hashed_as = "surface";
  Rows rows = {
      std::move(surface),
      {.name = "first_level",
       .kind = Kind::kInteger,
       .help = "finest level to store; renderers take finer ones from the normal map",
       .low = 0,
       .high = 15,  // the coarsest of a map of 32768 texels a side
       .default_text = "0",
       .hashed_as = "first_level",
       .surfaces = kJob},
      {.name = "data_format",
       .kind = Kind::kChoice,
       .help = "storage precision; half does not keep kappa above 1000 of lobes, and is the default of moments and sh",
       .default_text = "snorm16",
       .choices = choice_names(kStorageEncodings),
       .hashed_as = "encoding",
       .short_option = "-d",
       .chosen_by_target = true,
       .surfaces = kJob}};
  rows.push_back(compression_parameter(kJob));
  return rows;
}

Rows fit_rows() {
  Rows rows = {
      {.name = "lobes",
       .kind = Kind::kInteger,
       .help = "lobes per texel; more are larger, slower and usually more accurate",
       .low = 1,
       .high = 8,
       .default_text = "4",
       .hashed_as = "lobes",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "reference",
       .help = "fit every normal at every level, 30 iterations, none cut short: slower; the defaults are measured "
               "against it",
       .hashed_as = "settled_change",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "iterations",
       .kind = Kind::kInteger,
       .help = "most EM iterations per texel",
       .low = 1,
       .high = 1000,
       .default_text = "12",
       .hashed_as = "iterations",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "passes",
       .kind = Kind::kInteger,
       .help = "passes over a level; more than one aligns its lobes better",
       .low = 1,
       .high = 8,
       .default_text = "2",
       .hashed_as = "sweeps",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refit_iterations",
       .kind = Kind::kInteger,
       .help = "most EM iterations per texel in each further pass",
       .low = 1,
       .high = 1000,
       .default_text = "6",
       .hashed_as = "iterations_again",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refine",
       .help =
           "after EM, refine the lobes of each texel towards the highlights that they give: nearer, slower; for vmf "
           "and binned normals",
       .hashed_as = "refined",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "order",
       .kind = Kind::kChoice,
       .help = "order of fitting texels: colour (in parallel) or scanline (the paper's)",
       .default_text = "colour",
       .choices = choice_names(kFitOrders),
       .hashed_as = "order",
       .surfaces = kJob},
      {.name = "coarse_normals",
       .kind = Kind::kChoice,
       .help = "normals that coarse texels are fitted to: binned (one per bin of similar normals; faster) or all",
       .default_text = "binned",
       .choices = choice_names(kCoarseNormals),
       .hashed_as = "coarse_normals",
       .surfaces = kJob},
      {.name = "no_start_search",
       .help = "skip the start search: take the candidate of least error without trying them all; saves half a second",
       .hashed_as = "rehearse_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "farthest_start",
       .help = "start from normals that lie farthest apart (Hochbaum and Shmoys), as Han et al. 2007 do, for "
               "comparison: mostly a worse fit",
       .hashed_as = "farthest_start",
       .surfaces = kJob},
      {.name = "unaligned",
       .help = "fit every texel by itself, for comparison: filtering then mixes unlike lobes",
       .hashed_as = "aligned_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "align",
       .kind = Kind::kNumber,
       .help = "weight of the alignment prior; 0: none",
       .low = 0,
       .high = 10,
       .default_text = "0.1",
       .hashed_as = "align",
       .surfaces = kJob},
      {.name = "kappa_cap",
       .kind = Kind::kNumber,
       .help = "kappa of the sharpest lobe that EM uses on rough texels; smooth ones get sharper lobes",
       .low = 1,
       .high = 1e5,
       .default_text = "500",
       .hashed_as = "kappa_cap",
       .surfaces = kJob},
      // Hashed and checked, but nowhere given.
      {.name = "iterations_coarse",
       .kind = Kind::kInteger,
       .help = "most EM iterations of texels of more than 1024 normals; --iterations sets it, too",
       .low = 1,
       .high = 1000,
       .default_text = "30",
       .hashed_as = "iterations_coarse"},
      {.name = "iterations_top",
       .kind = Kind::kInteger,
       .help = "most EM iterations of the coarsest level",
       .low = 1,
       .high = 1000,
       .default_text = "60",
       .hashed_as = "iterations_top"},
      {.name = "convergence_tolerance",
       .kind = Kind::kNumber,
       .help = "relative change of kappa, weight and direction below which a texel has converged; 0: never",
       .low = 0,
       .high = 0.1,
       .default_text = "0.01",
       .hashed_as = "settled_change"},
      {.name = "kappa_cap_slope",
       .kind = Kind::kNumber,
       .help = "growth of kappa_cap per kappa of all the texel's normals",
       .low = 0,
       .high = 1000,
       .default_text = "10",
       .hashed_as = "kappa_cap_slope"},
      {.name = "start_kappa_factor",
       .kind = Kind::kNumber,
       .help = "kappa of a start as a share of the parent's",
       .low = 0.01,
       .high = 1,
       .default_text = "0.5",
       .hashed_as = "start_kappa_factor"},
      {.name = "start_amplitude_min",
       .kind = Kind::kNumber,
       .help = "smallest amplitude of a start's lobe",
       .low = 0,
       .high = 0.125,
       .default_text = "0.02",
       .hashed_as = "start_amplitude_min"}};
  for (Parameter& row : rows) row.scope = ParameterScope::kLobes;
  return rows;
}

Rows target_rows() {
  return {{.name = "target_error",
           .kind = Kind::kNumber,
           .help = "choose the cheapest settings whose error is at most this: relative L1 of pixels "
                   "against their reference, 0.1 for 10 %; where none reach it, write nothing and exit with code 5",
           .high = 2,
           .low_excluded = true,
           .excludes = {"budget_ms"},
           .surfaces = kJob},
          {.name = "budget_ms",
           .kind = Kind::kNumber,
           .help = "choose the most accurate settings that bake in this time: reading, fitting and writing",
           .high = kUnbounded,
           .low_excluded = true,
           .unit = "ms",
           .excludes = {"target_error"},
           .surfaces = kJob},
          {.name = "brdf",
           .kind = Kind::kBrdf,
           .help = "BRDF of a target's error: " + brdf_forms("") + " or, except in jobs, the file of a measured BRDF",
           .default_text = "blinn-phong:100",
           .surfaces = kJob},
          {.name = "best_effort",
           .help = "write the best settings where none reach the target; the exit code stays 5",
           .surfaces = kJob},
          {.name = "error_max",
           .kind = Kind::kNumber,
           .help = "largest measured error that passes: relative L1, 0.1 for 10 %, of the worst level and BRDF",
           .high = kUnbounded,
           .low_excluded = true,
           .surfaces = kInManifest}};
}

Rows run_rows() {
  return {
      memory_parameter("resident memory to stay within: larger maps are baked in bands of rows, with the same result",
                       kLeastMemory, "as much as makes it faster, at most a quarter of the machine's",
                       kOnCommandLine | kInService),
      device_parameter(kOnCommandLine | kInService),
      {.name = "no_measure", .help = "skip measuring the error of the output", .surfaces = kOnCommandLine | kInService},
      {.name = "report",
       .kind = Kind::kText,
       .help = "write times, counts and errors as JSON; for several maps: a folder, or a name with <UDIM>",
       .unit = "FILE",
       .surfaces = kOnCommandLine},
      {.name = "scalar",
       .help = "work as on a GPU, with scalar kernels, teams of work-items and copies: same bytes, slower on CPUs",
       .surfaces = kOnCommandLine},
      {.name = "scratch",
       .kind = Kind::kText,
       .help = "folder for data that does not fit in memory",
       .unit = "FOLDER",
       .default_text = "the output's",
       .surfaces = kOnCommandLine},
      {.name = "resume", .help = "resume an interrupted bake of the same output", .surfaces = kOnCommandLine},
      {.name = "region",
       .kind = Kind::kText,
       .help =
           "fit only this edited part of the map again, and keep the rest of --onto; auto: find the part that changed",
       .unit = "X,Y,W,H|auto",
       .surfaces = kOnCommandLine},
      {.name = "onto",
       .kind = Kind::kFile,
       .help = "file that was baked before the edit; may be the output",
       .surfaces = kOnCommandLine},
      {.name = "force",
       .help = "bake even if the output comes from the same file with the same settings",
       .surfaces = kOnCommandLine},
      {.name = "runstats", .help = "print times, launches and numerical events", .surfaces = kOnCommandLine}};
}

}  // namespace

const ParameterTable& bake_parameters() {
  static const ParameterTable table = [] {
    Rows rows = {input_parameter("input", "normal map or height field: PNG, TIFF, EXR, JPEG or WebP, sides to 32768",
                                 kInManifest | kInService)};
    add(rows, material_rows(), kMaterialGroup);
    // In this order, since texts of options have it: what it is, how it is fitted, how it is stored.
    add(rows, representation_rows(), kStorageGroup);
    add(rows, fit_rows(), kFitGroup);
    add(rows, storage_rows(), kStorageGroup);
    add(rows, source_rows(), kSourceGroup);
    add(rows, target_rows(), kTargetGroup);
    add(rows, run_rows(), kRunGroup);
    return ParameterTable("bake", std::move(rows));
  }();
  return table;
}

const ParameterTable& scene_parameters() {
  static const ParameterTable table(
      "scene", {input_parameter("scene", "scene.toml: maps, materials, objects, lights, camera", kInService),
                memory_parameter("resident memory to stay within", kLeastMemory,
                                 "as much as makes it faster, at most a quarter of the machine's", kInService),
                device_parameter(kInService)});
  return table;
}

}  // namespace multum
