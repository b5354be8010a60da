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
               "stored in red, green and blue",
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
       .help = "set the height difference between the values 0 and 1 of a height field; a negative number turns dents "
               "into bumps",
       .low = -kUnbounded,
       .high = kUnbounded,
       .zero_excluded = true,
       .unit = "texels",
       .default_text = "1",
       .hashed_as = "height_scale",
       .surfaces = kEverywhere},
      {.name = "dequantize",
       .help = "replace 8-bit heights with the smoothest heights that round to them, which turns terraces into slopes;"
               " steps of two or more codes are kept",
       .hashed_as = "dequantize",
       .surfaces = kEverywhere},
      {.name = "normal_scale",
       .kind = Kind::kNumber,
       .help = "multiply the x and y components of normals by this number, like normalTexture.scale in glTF",
       .low = -kUnbounded,
       .high = kUnbounded,
       .default_text = "1",
       .hashed_as = "normal_scale",
       .surfaces = kEverywhere},
      {.name = "fixnan",
       .kind = Kind::kChoice,
       .help = "repair NaN and infinite texels: none (reject the file), black (use a flat normal) or box3 (use the "
               "mean of the 3 x 3 neighbours)",
       .default_text = "box3",
       .choices = choice_names(kFixNans),
       .hashed_as = "fixnan",
       .surfaces = kEverywhere},
      {.name = "repair_max",
       .kind = Kind::kNumber,
       .help = "reject a file if a larger share of its texels needs repair",
       .low = 0.0,
       .high = 1.0,
       .default_text = "0.01",
       .surfaces = kEverywhere},
      {.name = "checknan",
       .help = "reject a file that contains a NaN or infinite texel, and name the first such texel",
       .surfaces = kEverywhere}};
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
           .help = "bake this perceptual roughness map (0 to 1, same size) into the lobes; drawing then needs no BRDF",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"gloss"},
           .surfaces = kEverywhere},
          {.name = "gloss",
           .kind = Kind::kFile,
           .help = "bake this gloss map instead of a roughness map; roughness = 1 - gloss",
           .unit = "FILE[:CHANNEL]",
           .hashed_as = "roughness",
           .excludes = {"roughness"},
           .surfaces = kEverywhere},
          {.name = "weights",
           .kind = Kind::kFile,
           .help = "bake blend weights of 1 to 4 basis BRDFs, per lobe or averaged; the map has the same size and one "
                   "channel (0 to 1) per BRDF",
           .hashed_as = "weights",
           .surfaces = kEverywhere}};
}

Rows representation_rows() {
  return {{.name = "ndf",
           .kind = Kind::kChoice,
           .help = "store normals as vmf (lobes, Han 2007, most accurate), moments (slopes and their squares, LEAN), "
                   "gmm (planar Gaussians, Tan 2005) or sh (spherical harmonics)",
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
  Parameter surface = surface_parameter("; interpolated implies --first-level 1", kJob);
  surface.hashed_as = "surface";
  Rows rows = {std::move(surface),
               {.name = "first_level",
                .kind = Kind::kInteger,
                .help = "store only this level and coarser levels; renderers read finer levels from the normal map",
                .low = 0,
                .high = 15,  // the coarsest level of a map with 32768 texels per side
                .default_text = "0",
                .hashed_as = "first_level",
                .surfaces = kJob},
               {.name = "data_format",
                .kind = Kind::kChoice,
                .help = "set the storage precision; half, the default for moments and sh, is inaccurate for lobes with"
                        " kappa above 1000",
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
       .help = "fit every normal at every level with 30 iterations and no early stop; the default settings are "
               "compared with this slow fit",
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
       .help = "fit each level this many times; later passes align its lobes better",
       .low = 1,
       .high = 8,
       .default_text = "2",
       .hashed_as = "sweeps",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refit_iterations",
       .kind = Kind::kInteger,
       .help = "run at most this many EM iterations per texel in each pass after the first",
       .low = 1,
       .high = 1000,
       .default_text = "6",
       .hashed_as = "iterations_again",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "refine",
       .help = "refine the lobes of each texel after EM, which makes highlights more accurate but is slower; only for "
               "vmf with binned normals",
       .hashed_as = "refined",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "order",
       .kind = Kind::kChoice,
       .help = "fit texels in four groups without neighbours, each in parallel (colour), or row by row as in the paper"
               " (scanline)",
       .default_text = "colour",
       .choices = choice_names(kFitOrders),
       .hashed_as = "order",
       .surfaces = kJob},
      {.name = "coarse_normals",
       .kind = Kind::kChoice,
       .help = "fit coarse texels either to one normal per bin of similar normals (binned, faster) or to all normals "
               "(all)",
       .default_text = "binned",
       .choices = choice_names(kCoarseNormals),
       .hashed_as = "coarse_normals",
       .surfaces = kJob},
      {.name = "no_start_search",
       .help = "choose the starting values of the coarsest level without test fits on a small proxy map, which saves "
               "half a second",
       .hashed_as = "rehearse_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "farthest_start",
       .help = "start from the normals that are farthest apart (Hochbaum and Shmoys), as in Han et al. 2007; only for "
               "comparisons, because the fit is usually worse",
       .hashed_as = "farthest_start",
       .surfaces = kJob},
      {.name = "unaligned",
       .help = "fit every texel independently; only for comparisons, because texture filters then mix lobes that do "
               "not match",
       .hashed_as = "aligned_start",
       .chosen_by_target = true,
       .surfaces = kJob},
      {.name = "align",
       .kind = Kind::kNumber,
       .help = "set the weight of the prior that aligns lobes with those of the parent and neighbouring texels; 0 "
               "turns the prior off",
       .low = 0,
       .high = 10,
       .default_text = "0.1",
       .hashed_as = "align",
       .surfaces = kJob},
      {.name = "kappa_cap",
       .kind = Kind::kNumber,
       .help = "limit the kappa of lobes on rough texels during EM; smooth texels get sharper lobes",
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
       .help = "largest fraction by which kappa, weight and direction of a converged texel may change; with 0, no "
               "texel converges",
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
           .help = "choose the cheapest settings whose relative L1 error of pixels is at most this (0.1 means 10 %); "
                   "if there are none, write nothing and exit with code 5",
           .high = 2,
           .low_excluded = true,
           .excludes = {"budget_ms"},
           .surfaces = kJob},
          {.name = "budget_ms",
           .kind = Kind::kNumber,
           .help = "choose the most accurate settings whose bake, including reading and writing, takes at most this "
                   "time",
           .high = kUnbounded,
           .low_excluded = true,
           .unit = "ms",
           .excludes = {"target_error"},
           .surfaces = kJob},
          {.name = "brdf",
           .kind = Kind::kBrdf,
           .help = "use this BRDF to measure the error that a target limits: " + brdf_forms("") +
                   " or, except in jobs, the file of a measured BRDF",
           .default_text = "blinn-phong:100",
           .surfaces = kJob},
          {.name = "best_effort",
           .help = "if no settings reach the target, bake with the best settings found; the exit code is still 5",
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
          "limit the resident memory to this size; larger maps are baked in bands of rows, with the same result",
          kLeastMemory, "as much as is useful, at most a quarter of the memory of the machine",
          kOnCommandLine | kInService),
      device_parameter(kOnCommandLine | kInService),
      {.name = "no_measure", .help = "do not measure the error of the output", .surfaces = kOnCommandLine | kInService},
      {.name = "report",
       .kind = Kind::kText,
       .help = "write times, counts and errors to this file as JSON; for several maps, give a folder or a name with "
               "<UDIM>",
       .unit = "FILE",
       .surfaces = kOnCommandLine},
      {.name = "scalar",
       .help = "run the kernels as on a GPU (scalar, with teams of work-items and copies); the result is the same, but"
               " a CPU is slower",
       .surfaces = kOnCommandLine},
      {.name = "scratch",
       .kind = Kind::kText,
       .help = "write data that does not fit in memory to files in this folder",
       .unit = "FOLDER",
       .default_text = "the folder of the output",
       .surfaces = kOnCommandLine},
      {.name = "resume", .help = "resume an interrupted bake of the same output", .surfaces = kOnCommandLine},
      {.name = "region",
       .kind = Kind::kText,
       .help = "fit only this edited part again, and copy the other texels from the file of --onto; auto finds the "
               "edited part",
       .unit = "X,Y,W,H|auto",
       .surfaces = kOnCommandLine},
      {.name = "onto",
       .kind = Kind::kFile,
       .help = "update this file, which was baked before the edit; the output can have the same name",
       .surfaces = kOnCommandLine},
      {.name = "force",
       .help = "bake again even if the source and the settings have not changed",
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

std::vector<Parameter> reading_parameters(unsigned surfaces) {
  Rows rows;
  for (const Parameter& row : bake_parameters().rows())
    if (row.group == kSourceGroup) rows.push_back(row);
  for (Parameter& row : rows) {
    row.surfaces = surfaces;
    row.hashed_as.clear();
  }
  return rows;
}

const ParameterTable& scene_parameters() {
  static const ParameterTable table(
      "scene",
      {input_parameter("scene", "scene.toml, which lists maps, materials, objects, lights and the camera", kInService),
       memory_parameter("limit the resident memory to this size", kLeastMemory,
                        "as much as is useful, at most a quarter of the memory of the machine", kInService),
       device_parameter(kInService)});
  return table;
}

}  // namespace multum
