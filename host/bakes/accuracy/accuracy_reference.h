// SPDX-License-Identifier: Apache-2.0
// Computes the reference with which bakes are compared. The reference of a texel is an average over all finest normals
// that the texel covers. All averages are computed in one pass over the map, band by band. The pass needs memory for
// some rows per light or half vector, and for one value per measured texel.
//
// The directions of a band are divided among threads. For each direction, rows are added in order. The result therefore
// depends neither on the number of threads nor on the height of the bands.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/bakes/accuracy/brdf_rows.h"
#include "host/bakes/accuracy/footprint_averages.h"
#include "host/bakes/accuracy/highlight.h"
#include "host/bakes/accuracy/texel_averages.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The normals and the linear colours, both of the size of level 0. The colours may be null.
struct FinestPlanes {
  const PlaneStore& normals;
  const PlaneStore* albedo;
};

/// One row of the planes. Colours may be null.
struct FinestRow {
  int y;
  std::array<const float*, 3> normals;
  std::array<const float*, 3> albedo;
};

/// Sums over rows of the finest level.
class RowSums {
 public:
  virtual ~RowSums() = default;
  /// Adds a row. Call this function once per row, from the top.
  virtual void add_row(const FinestRow& row) = 0;
  /// Called after the last row.
  virtual void finish() {}
};

/// Computes averages of row values over the selected texels.
class TexelSums : public RowSums {
 public:
  void finish() override;
  /// Returns the average of value number `value` of a texel.
  double at(std::size_t slot, std::size_t value) const { return sums_[slot * value_count_ + value]; }

 protected:
  TexelSums(const TexelAverages& averages, std::size_t value_count)
      : averages_(averages), value_count_(value_count), sums_(averages.slot_count() * value_count) {}
  void add_value(std::size_t value, int y, double* row) {
    if (sums_.empty()) return;  // no texel was selected
    averages_.add_row(y, row, sums_.data() + value, value_count_);
  }

  const TexelAverages& averages_;

 private:
  std::size_t value_count_;
  std::vector<double> sums_;  // [slot][value]
};

/// Evaluates `count` values for each texel of a row, for one direction.
struct BrdfValues {
  std::size_t count;
  std::function<void(const std::array<const float*, 3>& normals, int width, const std::vector<double*>& rows)> evaluate;
};
/// max(0, omega . n)^s for each exponent.
BrdfValues power_values(const glm::dvec3& omega, const std::vector<double>& exponents);
/// f at the half vector `omega` for each highlight, divided by highlight_scale().
BrdfValues highlight_values(const glm::dvec3& omega, const std::vector<Highlight>& highlights);
/// Returns (s + 1) / (2 pi) for Blinn-Phong, which is averaged without this factor. Returns 1 for other BRDFs.
double highlight_scale(const Highlight& highlight);
/// Evaluates one value per shortened normal (evaluate_shortened()).
BrdfValues shortened_values(const glm::dvec3& omega, bool is_lambert);

/// Averages a BRDF times n . l over footprints. These averages are the reference of pixels. Value e belongs to
/// highlight e. If there are colours, value (1 + c) * count + e is the same, multiplied by colour channel c.
class FootprintReference : public RowSums {
 public:
  /// `values` are the highlights, which are multiplied by `cosines`. They are nullopt for Lambert, which uses only the
  /// cosines.
  FootprintReference(const FootprintAverages& averages, std::optional<BrdfValues> values, BrdfValues cosines,
                     bool has_colours);
  void add_row(const FinestRow& row) override;
  /// Adds a row of values that were evaluated for each highlight, or for Lambert.
  void add_values(const FinestRow& row, const std::vector<double*>& values);
  double at(std::size_t footprint, std::size_t value) const { return sums_[footprint * value_count_ + value]; }

 private:
  const FootprintAverages& averages_;
  const std::optional<BrdfValues> brdf_;
  const BrdfValues cosines_;
  const std::size_t highlight_count_, value_count_;
  std::vector<AlignedRow> rows_;  // [highlight]; Lambert has only one
  AlignedRow cosine_row_;
  std::vector<AlignedRow> coloured_;  // [highlight]; empty if there are no colours
  AlignedRow scratch_;                // for FootprintAverages
  std::vector<double> sums_;          // [footprint][value]
};

/// Averages BRDF values over texels. Value e belongs to BRDF e. If there are colours, value (1 + c) * count + e is the
/// same, multiplied by colour channel c.
class BrdfReference : public TexelSums {
 public:
  BrdfReference(const TexelAverages& averages, BrdfValues values, bool has_colours);
  void add_row(const FinestRow& row) override;
  /// Also passes the values to `footprints`, so that values that both objects need are evaluated only once. The object
  /// does not own `footprints`.
  void share_with(FootprintReference& footprints) { footprints_ = &footprints; }

 private:
  const BrdfValues brdf_;
  std::vector<AlignedRow> rows_;  // [exponent]
  AlignedRow coloured_;           // holds one row
  FootprintReference* footprints_ = nullptr;
};

/// Averages the planes themselves. Values 0 to 2 are the normal. Values 3 to 5 are the colour if there is one.
class PlaneAverages : public TexelSums {
 public:
  PlaneAverages(const TexelAverages& averages, bool has_colours);
  void add_row(const FinestRow& row) override;

 private:
  bool has_colours_;
  AlignedRow row_;
};

struct StreamSettings {
  int threads = 2;
  int rows_per_band = 0;  // 0 chooses bands of about 3 MB of normals
};

/// Adds every row to all of `sums` and finishes them. The function advances no progress units, but the progress
/// callback can cancel it between bands.
void stream_rows(const FinestPlanes& planes, const StreamSettings& settings, const std::vector<RowSums*>& sums,
                 Progress* progress);

}  // namespace multum
