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
constexpr double kLeastMemory = 288.0 * (1 << 20);  // 280 MiB for the program, and 8 MiB for a window (bake_job.cpp)

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
       .help = "set the kind of map; auto detects it from statistics; packed16 to mapbox are heights whose bytes are "
               "in red, green and blue",
       .default_text = "auto",
       .choices = choice_names(kBumpFormats),
       .hashed_as = "bump_format",
       .surfaces = kEverywhere},
      {.name = "green",
       .kind = Kind::kChoice,
       .help = "set the direction of green: up (OpenGL) or down (DirectX)",
       .default_text = "detected",
       .choices = choice_names(kGreenAxes),
       .hashed_as = "green",
       .surfaces = kEverywhere},
      {.name = "signed",
       .help = "read channel values as vector components from -1 to 1",
       .default_text = "detected",
       .hashed_as = "signed",
       .excludes = {"unsigned"},
       .surfaces = kEverywhere},
      {.name = "unsigned",
       .help = "read channel values as encoded components from 0 to 1",
       .default_text = "detected",
       .hashed_as = "signed",
       .excludes = {"signed"},
       .surfaces = kEverywhere},
      two_channel_parameter(kEverywhere),
      z_range_parameter(kEverywhere),
      {.name = "height_scale",
       .kind = Kind::kNumber,
       .help = "set the height for a value difference of 1 in a height field; a negative number turns dents into bumps",
       .low = -kUnbounded,
       .high = kUnbounded,
       .zero_excluded = true,
       .unit = "texels",
       .default_text = "1",
       .hashed_as = "height_scale",
       .surfaces = kEverywhere},
      {.name = "dequantize",
       .help = "replace 8-bit heights by the smoothest heights that round to them, so terraces become slopes; steps of "
               "two or more codes stay",
       .hashed_as = "dequantize",
       .surfaces = kEverywhere},
      {.name = "normal_scale",
       .kind = Kind::kNumber,
       .help = "multiply x and y of a normal map by this, like normalTexture.scale in glTF",
       .low = -kUnbounded,
       .high = kUnbounded,
       .default_text = "1",
       .hashed_as = "normal_scale",
       .surfaces = kEverywhere},
      {.name = "fixnan",
       .kind = Kind::kChoice,
       .help = "repair NaN and infinite texels: none (refuse the file), black (flat normal) or box3 (mean of "
               "the 3 x 3 neighbours)",
       .default_text = "box3",
       .choices = choice_names(kFixNans),
       .hashed_as = "fixnan",
       .surfaces = kEverywhere},
      {.name = "repair_max",
       .kind = Kind::kNumber,
       .help = "refuse a file if a larger share of its texels needs repair",
       .low = 0.0,
       .high = 1.0,
       .default_text = "0.01",
       .surfaces = kEverywhere},
      {.name = "checknan",
       .help = "refuse a file with a NaN or infinite texel, and name the first one",
       .surfaces = kEverywhere}};
  for (Parameter& row : wrap_parameters(true, "periodic", kEverywhere)) rows.push_back(std::move(row));
  return rows;
}

Rows material_rows() {
  return {{.name = "albedo",
           .kind = Kind::kFile,
           .help = "bake colours from this map of the same size, per lobe or averaged",
           .hashed_as = "albedo",
           .surfaces = kEverywhere},
          {.name = "roughness",
           .kind = Kind::kFile,
           .help = "bake this perceptual roughness map (0 to 1, same size) into the lobes; drawing then needs no BRDF",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"gloss"},
           .surfaces = kEverywhere},
          {.name = "gloss",
           .kind = Kind::kFile,
           .help = "bake this gloss map in place of --roughness; roughness = 1 - gloss",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"roughness"},
           .surfaces = kEverywhere},
          {.name = "weights",
           .kind = Kind::kFile,
           .help = "bake blend weights of 1 to 4 basis BRDFs, per lobe or averaged, from a map of the same size with "
                   "one channel (0 to 1) per BRDF",
           .hashed_as = "weights",
           .surfaces = kEverywhere}};
}

Rows representation_rows() {
  return {{.name = "ndf",
           .kind = Kind::kChoice,
           .help = "store normals as vmf (lobes, Han 2007; most accurate), moments (slopes and their squares, "
                   "LEAN), gmm (planar Gaussians, Tan 2005) or sh (spherical harmonics)",
           .default_text = "vmf",
           .choices = choice_names(kRepresentations),
           .hashed_as = "representation",
           .surfaces = kJob},
          {.name = "sh_order",
           .kind = Kind::kInteger,
           .help = "set the highest order of the harmonics: 4 for diffuse light, 8 for broad highlights",
           .low = 1,
           .high = 20,
           .default_text = "4",
           .hashed_as = "sh_order",
           .scope = ParameterScope::kHarmonics,
           .chosen_by_target = true,
           .surfaces = kJob}};
}

Rows storage_rows() {
  Parameter surface = surface_parameter("; level 0 is then the normal map (--first-level 1)", kJob);
  surface.hashed_as = "surface";
  Rows rows = {std::move(surface),
               {.name = "first_level",
                .kind = Kind::kInteger,
                .help = "store this level and coarser ones; renderers take finer levels from the normal map",
                .low = 0,
                .high = 15,  // the coarsest level of a map with 32768 texels per side
                .default_text = "0",
                .hashed_as = "first_level",
                .surfaces = kJob},
               {.name = "data_format",
                .kind = Kind::kChoice,
                .help = "set the storage precision; half, the default for moments and sh, is inaccurate for lobes with "
                        "kappa above 1000",
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
       .help = "fit this many lobes per texel; more lobes take more space and time and are usually more accurate",
       .low = 1,
       .high = 8,
       .default_text = "4",
       .hashed_as = "lobes",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "reference",
       .help = "fit every normal at every level with 30 iterations and no early stop; this slow fit is the reference "
               "for the defaults",
       .hashed_as = "settled_change",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "iterations",
       .kind = Kind::kInteger,
       .help = "run at most this many EM iterations per texel",
       .low = 1,
       .high = 1000,
       .default_text = "12",
       .hashed_as = "iterations",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "passes",
       .kind = Kind::kInteger,
       .help = "pass over each level this many times; later passes align its lobes better",
       .low = 1,
       .high = 8,
       .default_text = "2",
       .hashed_as = "sweeps",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refit_iterations",
       .kind = Kind::kInteger,
       .help = "run at most this many EM iterations per texel in each later pass",
       .low = 1,
       .high = 1000,
       .default_text = "6",
       .hashed_as = "iterations_again",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refine",
       .help = "refine the lobes of each texel after EM for better highlights: more accurate but slower; only for vmf "
               "with binned normals",
       .hashed_as = "refined",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "order",
       .kind = Kind::kChoice,
       .help = "fit texels in parallel in four groups without neighbours (colour), or row by row as in the paper "
               "(scanline)",
       .default_text = "colour",
       .choices = choice_names(kFitOrders),
       .hashed_as = "order",
       .surfaces = kJob},
      {.name = "coarse_normals",
       .kind = Kind::kChoice,
       .help = "fit coarse texels to one normal per bin of similar normals (binned, faster) or to all normals (all)",
       .default_text = "binned",
       .choices = choice_names(kCoarseNormals),
       .hashed_as = "coarse_normals",
       .surfaces = kJob},
      {.name = "no_start_search",
       .help = "choose the start of the coarsest level without test fits on a small proxy map; saves half a second",
       .hashed_as = "rehearse_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "farthest_start",
       .help = "start from the normals that are farthest apart (Hochbaum and Shmoys), as in Han et al. 2007; for "
               "comparison, because the fit is usually worse",
       .hashed_as = "farthest_start",
       .surfaces = kJob},
      {.name = "unaligned",
       .help = "fit every texel independently for comparison; texture filters then mix lobes that do not match",
       .hashed_as = "aligned_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "align",
       .kind = Kind::kNumber,
       .help = "set the weight of the prior that aligns lobes with the lobes of the parent texel and of neighbouring "
               "texels; 0 turns the prior off",
       .low = 0,
       .high = 10,
       .default_text = "0.1",
       .hashed_as = "align",
       .surfaces = kJob},
      {.name = "kappa_cap",
       .kind = Kind::kNumber,
       .help = "limit the kappa of lobes during EM on rough texels; smooth texels get sharper lobes",
       .low = 1,
       .high = 1e5,
       .default_text = "500",
       .hashed_as = "kappa_cap",
       .surfaces = kJob},
      // These parameters are hashed and checked, but users cannot set them.
      {.name = "iterations_coarse",
       .kind = Kind::kInteger,
       .help = "maximum EM iterations for texels that cover more than 1024 normals; --iterations replaces it",
       .low = 1,
       .high = 1000,
       .default_text = "30",
       .hashed_as = "iterations_coarse"},
      {.name = "iterations_top",
       .kind = Kind::kInteger,
       .help = "maximum EM iterations for the coarsest level",
       .low = 1,
       .high = 1000,
       .default_text = "60",
       .hashed_as = "iterations_top"},
      {.name = "convergence_tolerance",
       .kind = Kind::kNumber,
       .help = "relative change of kappa, weight and direction below which a texel has converged; with 0, no texel "
               "converges",
       .low = 0,
       .high = 0.1,
       .default_text = "0.01",
       .hashed_as = "settled_change"},
      {.name = "kappa_cap_slope",
       .kind = Kind::kNumber,
       .help = "increase of kappa_cap per unit of the kappa of all normals in the texel",
       .low = 0,
       .high = 1000,
       .default_text = "10",
       .hashed_as = "kappa_cap_slope"},
      {.name = "start_kappa_factor",
       .kind = Kind::kNumber,
       .help = "kappa of a starting lobe as a share of the parent's kappa",
       .low = 0.01,
       .high = 1,
       .default_text = "0.5",
       .hashed_as = "start_kappa_factor"},
      {.name = "start_amplitude_min",
       .kind = Kind::kNumber,
       .help = "smallest amplitude of a starting lobe",
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
           .help = "choose the cheapest settings within this relative L1 error of pixels (0.1 means 10 %); if none "
                   "reach it, write nothing and exit with code 5",
           .high = 2,
           .low_excluded = true,
           .excludes = {"budget_ms"},
           .surfaces = kJob},
          {.name = "budget_ms",
           .kind = Kind::kNumber,
           .help = "choose the most accurate settings whose bake (reading, fitting, writing) takes at most this time",
           .high = kUnbounded,
           .low_excluded = true,
           .unit = "ms",
           .excludes = {"target_error"},
           .surfaces = kJob},
          {.name = "brdf",
           .kind = Kind::kBrdf,
           .help = "measure the error for a target with this BRDF: " + brdf_forms("") +
                   " or, except in jobs, the file of a measured BRDF",
           .default_text = "blinn-phong:100",
           .surfaces = kJob},
          {.name = "best_effort",
           .help = "bake with the best settings found even if they miss the target; the exit code stays 5",
           .surfaces = kJob},
          {.name = "error_max",
           .kind = Kind::kNumber,
           .help = "fail if the relative L1 error of the worst level and BRDF is above this (0.1 means 10 %)",
           .high = kUnbounded,
           .low_excluded = true,
           .surfaces = kInManifest}};
}

Rows run_rows() {
  return {
      memory_parameter(
          "use at most this much resident memory; larger maps are baked in bands of rows, with the same result",
          kLeastMemory, "as much as is useful, at most a quarter of the memory of the machine",
          kOnCommandLine | kInService),
      device_parameter(kOnCommandLine | kInService),
      {.name = "no_measure", .help = "skip measuring the error of the output", .surfaces = kOnCommandLine | kInService},
      {.name = "report",
       .kind = Kind::kText,
       .help = "write times, counts and errors as JSON; for several maps, to a folder or to a name with <UDIM>",
       .unit = "FILE",
       .surfaces = kOnCommandLine},
      {.name = "scalar",
       .help = "run the kernels as on a GPU (scalar, with teams of work-items and copies); the result is the same, but "
               "CPUs are slower",
       .surfaces = kOnCommandLine},
      {.name = "scratch",
       .kind = Kind::kText,
       .help = "store data that does not fit in memory in this folder",
       .unit = "FOLDER",
       .default_text = "the folder of the output",
       .surfaces = kOnCommandLine},
      {.name = "resume", .help = "resume an interrupted bake of the same output", .surfaces = kOnCommandLine},
      {.name = "region",
       .kind = Kind::kText,
       .help = "fit only this edited part again and keep the rest of --onto; auto finds the changed part",
       .unit = "X,Y,W,H|auto",
       .surfaces = kOnCommandLine},
      {.name = "onto",
       .kind = Kind::kFile,
       .help = "start from this file, which was baked before the edit; the output may be the same file",
       .surfaces = kOnCommandLine},
      {.name = "force",
       .help = "bake even if the output was baked from the same file with the same settings",
       .surfaces = kOnCommandLine},
      {.name = "runstats", .help = "print times, launches and numerical events", .surfaces = kOnCommandLine}};
}

}  // namespace

const ParameterTable& bake_parameters() {
  static const ParameterTable table = [] {
    Rows rows = {input_parameter(
        "input", "normal map or height field (PNG, TIFF, EXR, JPEG or WebP, up to 32768 texels per side)",
        kInManifest | kInService)};
    add(rows, material_rows(), kMaterialGroup);
    // Help texts show the groups in this order: representation, fit, storage.
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
      "scene", {input_parameter("scene", "scene.toml with maps, materials, objects, lights and camera", kInService),
                memory_parameter("stay within this resident memory", kLeastMemory,
                                 "as much as is useful, at most a quarter of the memory of the machine", kInService),
                device_parameter(kInService)});
  return table;
}

}  // namespace multum
