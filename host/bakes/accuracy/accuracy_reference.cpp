// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_reference.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

MULTUM_VECTOR_CLONES
void multiply_colour(const double* __restrict values, const float* __restrict colour, std::size_t count,
                     double* __restrict product) {
  for (std::size_t i = 0; i < count; ++i) product[i] = values[i] * static_cast<double>(colour[i]);
}

// Holds some rows of the planes in memory.
class Band {
 public:
  Band(const FinestPlanes& planes, int rows_per_band) : planes_(&planes) {
    values_.resize(static_cast<std::size_t>(rows_per_band) * width() * (planes.albedo != nullptr ? 6 : 3));
  }
  void read(int first_row, int row_count) {
    first_row_ = first_row;
    row_count_ = row_count;
    planes_->normals.read_rows(first_row, row_count, {plane(0), plane(1), plane(2)});
    if (planes_->albedo != nullptr) planes_->albedo->read_rows(first_row, row_count, {plane(3), plane(4), plane(5)});
  }
  int row_count() const { return row_count_; }
  FinestRow row(int number) {
    FinestRow row{first_row_ + number, {}, {}};
    const std::size_t offset = static_cast<std::size_t>(number) * width();
    for (std::size_t p = 0; p < 3; ++p) {
      row.normals[p] = plane(p) + offset;
      if (planes_->albedo != nullptr) row.albedo[p] = plane(3 + p) + offset;
    }
    return row;
  }

 private:
  std::size_t width() const { return static_cast<std::size_t>(planes_->normals.width()); }
  float* plane(std::size_t number) { return values_.data() + number * static_cast<std::size_t>(row_count_) * width(); }

  const FinestPlanes* planes_;
  std::vector<float> values_;
  int first_row_ = 0, row_count_ = 0;
};

int default_rows_per_band(const PlaneStore& normals) {
  constexpr int kTexelsPerBand = 1 << 18;  // a band takes a few milliseconds and fits into the last-level cache
  return std::clamp(kTexelsPerBand / normals.width(), 1, normals.height());
}

}  // namespace

void TexelSums::finish() {
  const TexelSelection& texels = averages_.texels();
  for (int level = 0; level < averages_.level_count(); ++level) {
    const double share = averages_.share(level);
    const std::size_t begin = texels.level_begin(level) * value_count_,
                      end = texels.level_begin(level + 1) * value_count_;
    for (std::size_t i = begin; i < end; ++i) sums_[i] *= share;
  }
}

BrdfValues power_values(const glm::dvec3& omega, const std::vector<double>& exponents) {
  const auto rows = std::make_shared<BrdfRows>(omega, exponents);
  return {exponents.size(),
          [rows](const auto& normals, int width, const auto& values) { rows->evaluate(normals, width, values); }};
}

namespace {

// e = 1 - omega . n = |n - omega|^2 / 2, where n is a unit vector. The second form gives e at full precision, which is
// necessary for a narrow f.
void evaluate_density(const Brdf& brdf, const glm::dvec3& omega, const std::array<const float*, 3>& normals, int count,
                      double* values) {
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 n(static_cast<double>(normals[0][i]), static_cast<double>(normals[1][i]),
                       static_cast<double>(normals[2][i]));
    const glm::dvec3 apart = n - omega;
    values[i] = grey_density(brdf, 0.5 * glm::dot(apart, apart));
  }
}

}  // namespace

BrdfValues highlight_values(const glm::dvec3& omega, const std::vector<Highlight>& highlights) {
  std::vector<double> exponents;
  for (const Highlight& one : highlights)
    if (one.brdf.kind == BrdfKind::kBlinnPhong) exponents.push_back(static_cast<double>(one.brdf.exponent));
  const auto powers = std::make_shared<BrdfRows>(omega, exponents);
  return {highlights.size(), [omega, highlights, powers](const auto& normals, int width, const auto& rows) {
            std::vector<double*> power_rows;
            for (std::size_t f = 0; f < highlights.size(); ++f)
              if (highlights[f].brdf.kind == BrdfKind::kBlinnPhong) power_rows.push_back(rows[f]);
              else evaluate_density(highlights[f].brdf, omega, normals, width, rows[f]);
            if (!power_rows.empty()) powers->evaluate(normals, width, power_rows);
          }};
}

double highlight_scale(const Highlight& highlight) {
  if (highlight.brdf.kind != BrdfKind::kBlinnPhong) return 1.0;
  return (static_cast<double>(highlight.brdf.exponent) + 1.0) / (2.0 * std::numbers::pi);
}

BrdfValues shortened_values(const glm::dvec3& omega, bool is_lambert) {
  return {1, [omega, is_lambert](const auto& normals, int width, const auto& values) {
            evaluate_shortened(omega, is_lambert, normals, width, values[0]);
          }};
}

BrdfReference::BrdfReference(const TexelAverages& averages, BrdfValues values, bool has_colours)
    : TexelSums(averages, values.count * (has_colours ? 4 : 1)),
      brdf_(std::move(values)),
      rows_(brdf_.count, AlignedRow(averages.row_length())),
      coloured_(has_colours ? averages.row_length() : 0) {}

void BrdfReference::add_row(const FinestRow& row) {
  const auto width = static_cast<std::size_t>(averages_.texels().sizes().front().width);
  std::vector<double*> rows;
  for (AlignedRow& values : rows_) rows.push_back(values.data());
  brdf_.evaluate(row.normals, static_cast<int>(width), rows);
  for (std::size_t e = 0; e < rows.size(); ++e) {
    add_value(e, row.y, rows[e]);
    for (std::size_t channel = 0; channel < 3 && !coloured_.empty(); ++channel) {
      multiply_colour(rows[e], row.albedo[channel], width, coloured_.data());
      add_value((channel + 1) * rows.size() + e, row.y, coloured_.data());
    }
  }
  if (footprints_ != nullptr) footprints_->add_values(row, rows);
}

FootprintReference::FootprintReference(const FootprintAverages& averages, std::optional<BrdfValues> values,
                                       BrdfValues cosines, bool has_colours)
    : averages_(averages),
      brdf_(std::move(values)),
      cosines_(std::move(cosines)),
      highlight_count_(brdf_ ? brdf_->count : 1),
      value_count_(highlight_count_ * (has_colours ? 4 : 1)),
      rows_(highlight_count_, AlignedRow(static_cast<std::size_t>(averages.map_width()))),
      cosine_row_(brdf_ ? static_cast<std::size_t>(averages.map_width()) : 0),
      coloured_(has_colours ? highlight_count_ : 0, AlignedRow(static_cast<std::size_t>(averages.map_width()))),
      scratch_(averages.scratch_length()),
      sums_(averages.footprints().size() * value_count_) {}

void FootprintReference::add_row(const FinestRow& row) {
  if (!averages_.needs_row(row.y)) return;
  std::vector<double*> rows;
  for (AlignedRow& values : rows_) rows.push_back(values.data());
  (brdf_ ? *brdf_ : cosines_).evaluate(row.normals, averages_.map_width(), rows);
  add_values(row, rows);
}

void FootprintReference::add_values(const FinestRow& row, const std::vector<double*>& values) {
  if (!averages_.needs_row(row.y)) return;
  const double* factors = nullptr;
  if (brdf_) {
    cosines_.evaluate(row.normals, averages_.map_width(), {cosine_row_.data()});
    factors = cosine_row_.data();
  }
  std::vector<const double*> planes(values.begin(), values.end());
  averages_.add_rows(row.y, planes, factors, scratch_, sums_.data(), value_count_);
  for (std::size_t channel = 0; channel < 3 && !coloured_.empty(); ++channel) {
    for (std::size_t e = 0; e < values.size(); ++e) {
      multiply_colour(values[e], row.albedo[channel], static_cast<std::size_t>(averages_.map_width()),
                      coloured_[e].data());
      planes[e] = coloured_[e].data();
    }
    averages_.add_rows(row.y, planes, factors, scratch_, sums_.data() + (channel + 1) * values.size(), value_count_);
  }
}

PlaneAverages::PlaneAverages(const TexelAverages& averages, bool has_colours)
    : TexelSums(averages, has_colours ? 6 : 3), has_colours_(has_colours), row_(averages.row_length()) {}

void PlaneAverages::add_row(const FinestRow& row) {
  const int width = averages_.texels().sizes().front().width;
  for (std::size_t value = 0; value < (has_colours_ ? 6u : 3u); ++value) {
    std::copy_n(value < 3 ? row.normals[value] : row.albedo[value - 3], width, row_.data());
    add_value(value, row.y, row_.data());
  }
}

// While the other threads evaluate a band, one thread reads the next.
void stream_rows(const FinestPlanes& planes, const StreamSettings& settings, const std::vector<RowSums*>& sums,
                 Progress* progress) {
  const int height = planes.normals.height();
  MULTUM_CHECK(planes.albedo == nullptr ||
               (planes.albedo->width() == planes.normals.width() && planes.albedo->height() == height));
  const int rows_per_band =
      settings.rows_per_band > 0 ? std::min(settings.rows_per_band, height) : default_rows_per_band(planes.normals);
  Band current(planes, rows_per_band), next(planes, rows_per_band);
  current.read(0, rows_per_band);
  for (int first_row = 0; first_row < height; first_row += rows_per_band) {
    progress_advance(progress, 0);  // lets the caller cancel
    const int next_row = first_row + rows_per_band;
    for_each_item(static_cast<int>(sums.size()) + 1, settings.threads, [&](int item) {
      if (item == 0 && next_row < height) next.read(next_row, std::min(rows_per_band, height - next_row));
      if (item == 0) return;
      for (int i = 0; i < current.row_count(); ++i) sums[static_cast<std::size_t>(item) - 1]->add_row(current.row(i));
    });
    std::swap(current, next);
  }
  for (RowSums* one : sums) one->finish();
}

}  // namespace multum
