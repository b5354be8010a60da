// SPDX-License-Identifier: Apache-2.0
// Measures the error of an export on sampled texels of some levels. The same texels are also measured with the engines'
// rules, with the best single lobe that a search finds, and with the lobes of a baked file. The results are the
// relative L1 error and the energy of the highlight over views and lights
// (host/delivery/export/accuracy/cell_reference.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/delivery/export/accuracy/cell_reference.h"
#include "host/delivery/export/baked_lobes.h"
#include "host/delivery/export/material_folder.h"
#include "host/delivery/export/material_rows.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct ExportAccuracySettings {
  std::vector<int> levels = {2, 4, 6};  // levels to measure; levels that the map does not have are skipped
  int cells_per_level = 16;             // measured texels per level
  // With this number, the median of the standard errors of the reference's integral, per level and map of
  // docs/evidence/EXPORT.md, is below 1 %.
  int lights_per_view = 256;
  int wide_lights_per_view = 24;
  bool finds_optimum = false;  // also search for the best single lobe
  // The format to which the engines' textures are rounded, so that all rows of the table have the same precision. If
  // nullopt, these textures are not rounded.
  std::optional<MaterialTexels> texels;
};

/// The error of one rule in one texel.
struct RuleError {
  LobeError point, wide;  // under point lights, and under lights 20 degrees across
};

struct CellAccuracy {
  int level, x, y;
  double noise;                   // standard error of the reference's integral, relative to the integral
  std::vector<RuleError> errors;  // errors by rule
};

/// The results of all cells of a level.
struct LevelAccuracy {
  int level;
  double noise;
  std::vector<RuleError> errors;  // means over cells with equal weights, by rule
};

struct ExportAccuracy {
  int lights_per_view = 0;
  std::vector<std::string> ids, names;  // ids and names of the rules; the export is first
  std::vector<CellAccuracy> cells;
  std::vector<LevelAccuracy> levels;

  /// Prints a table with one rule per line.
  std::string to_text() const;
  /// Returns a JSON array of levels and a JSON array of cells.
  std::string to_json() const;
};

/// Collects the stored rows of an export and then measures them.
class ExportMeter : public MaterialSink {
 public:
  /// `baked` is a file with the levels whose lobes are also measured, or null. The file must outlive this object.
  ExportMeter(int width, int height, const ExportAccuracySettings& settings, BakedLobes* baked = nullptr);
  void add_level(int level, int first_row, MaterialRows rows) override;
  /// Measures the error after all rows have arrived. Progress receives the name of the stage, and its callback can
  /// cancel between cells. No progress units are advanced.
  ExportAccuracy run(const OneLobeInputs& inputs, const OneLobeSettings& settings, Progress* progress);

 private:
  struct Cell {
    int level, x, y;
    int width, height;  // size of the level
    GgxLobe lobe;       // the exported lobe
    std::vector<glm::dvec4> baked;
  };
  CellAccuracy measure(const Cell& cell, const OneLobeInputs& inputs, const OneLobeSettings& settings) const;

  ExportAccuracySettings settings_;
  BakedLobes* const baked_;
  std::vector<Cell> cells_;
};

/// Returns a texel of exported rows in the form in which a renderer reads it.
GgxLobe lobe_of_texel(const MaterialRows& rows, std::size_t i);

}  // namespace multum
