// SPDX-License-Identifier: Apache-2.0
// The error of an export, measured on sampled texels of some levels beside what engines' rules make of the same map and
// the best one lobe that a search finds, and beside the lobes of a baked file: relative L1 error and energy of the
// highlight, over views and lights (host/delivery/export/accuracy/cell_reference.h).
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
  std::vector<int> levels = {2, 4, 6};  // those that the map has
  int cells_per_level = 16;             // texels that are looked at
  // The standard error of a map's and level's integral is then below 1 % in the median of docs/evidence/EXPORT.md's
  // maps.
  int lights_per_view = 256;
  int wide_lights_per_view = 24;
  bool finds_optimum = false;  // searched for beside the others
  // As which engines' textures are rounded too, so that no row has a precision that another lacks; nullopt: not at all.
  std::optional<MaterialTexels> texels;
};

/// Of one rule in one texel.
struct RuleError {
  LobeError point, wide;  // under point lights, and lights 20 degrees across
};

struct CellAccuracy {
  int level, x, y;
  double noise;                   // standard error of the reference's integral, over itself
  std::vector<RuleError> errors;  // by rule
};

/// All of a level's cells together.
struct LevelAccuracy {
  int level;
  double noise;
  std::vector<RuleError> errors;  // by rule: means over cells, which count alike
};

struct ExportAccuracy {
  int lights_per_view = 0;
  std::vector<std::string> ids, names;  // of rules: the export first
  std::vector<CellAccuracy> cells;
  std::vector<LevelAccuracy> levels;

  /// A table to print, a rule a line.
  std::string to_text() const;
  /// A JSON array of levels, and one of cells.
  std::string to_json() const;
};

/// Sees the rows of an export as they are stored, then measures.
class ExportMeter : public MaterialSink {
 public:
  /// `baked`: lobes to measure beside, of a file that has the levels; null: none. Must outlive it.
  ExportMeter(int width, int height, const ExportAccuracySettings& settings, BakedLobes* baked = nullptr);
  void add_level(int level, int first_row, MaterialRows rows) override;
  /// After all rows. Progress: names its stage and cancels between cells; counts no units.
  ExportAccuracy run(const OneLobeInputs& inputs, const OneLobeSettings& settings, Progress* progress);

 private:
  struct Cell {
    int level, x, y;
    int width, height;  // of the level
    GgxLobe lobe;       // as exported
    std::vector<glm::dvec4> baked;
  };
  CellAccuracy measure(const Cell& cell, const OneLobeInputs& inputs, const OneLobeSettings& settings) const;

  ExportAccuracySettings settings_;
  BakedLobes* const baked_;
  std::vector<Cell> cells_;
};

/// A texel of exported rows as a renderer has it.
GgxLobe lobe_of_texel(const MaterialRows& rows, std::size_t i);

}  // namespace multum
