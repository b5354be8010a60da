// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/surface_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr float kBeside = 0.211324865f;  // distance (1 - 1 / sqrt 3) / 2 of the two-point Gauss rule, in texels

// The directions (1 or -1) in which the point of a texel is moved towards a neighbour. Each neighbour has the weight
// kBeside.
int step_x(int x, int y) { return (x + y) % 2 == 0 ? 1 : -1; }
int step_y(int x) { return x % 4 == 0 || x % 4 == 3 ? 1 : -1; }

int continued(int texel, int size, WrapMode wrap) {
  if (wrap == WrapMode::kPeriodic) return (texel + size) % size;
  return std::clamp(texel, 0, size - 1);
}

// Three planes. If the planes hold normals, they also include the lengths of these normals.
struct Row {
  explicit Row(std::size_t width)
      : planes{std::vector<float>(width), std::vector<float>(width), std::vector<float>(width)}, lengths(width) {}

  void read(const PlaneStore& texels, int y, bool are_normals) {
    texels.read_rows(y, 1, {planes[0].data(), planes[1].data(), planes[2].data()});
    if (!are_normals) return;
    for (std::size_t x = 0; x < lengths.size(); ++x)
      lengths[x] = std::sqrt(planes[0][x] * planes[0][x] + planes[1][x] * planes[1][x] + planes[2][x] * planes[2][x]);
  }

  std::array<std::vector<float>, 3> planes;
  std::vector<float> lengths;
};

// Makes rows of points one after another. Each row needs the rows above and below it.
class PointRows {
 public:
  PointRows(const PlaneStore& texels, const MapWrap& wrap, bool are_normals)
      : texels_(texels),
        wrap_(wrap),
        are_normals_(are_normals),
        above_(size_of(texels.width())),
        row_(size_of(texels.width())),
        below_(size_of(texels.width())),
        points_(size_of(texels.width())) {}

  void make(int begin, int end, PlaneStore& to) {
    read(begin - 1, above_);
    read(begin, row_);
    for (int y = begin; y < end; ++y) {
      read(y + 1, below_);
      for (std::size_t p = 0; p < 3; ++p)
        interpolate(
            y, [p](const Row& row) { return row.planes[p].data(); }, points_.planes[p].data());
      if (are_normals_) {
        interpolate(
            y, [](const Row& row) { return row.lengths.data(); }, points_.lengths.data());
        lengthen();
      }
      to.write_rows(y, 1, {points_.planes[0].data(), points_.planes[1].data(), points_.planes[2].data()});
      std::swap(above_, row_);
      std::swap(row_, below_);
    }
  }

 private:
  void read(int y, Row& row) const { row.read(texels_, continued(y, texels_.height(), wrap_.t), are_normals_); }

  template <typename Values>
  void interpolate(int y, const Values& values_of, float* points) const {
    const float *own = values_of(row_), *above = values_of(above_), *below = values_of(below_);
    for (int x = 0; x < texels_.width(); ++x) {
      const int next = continued(x + step_x(x, y), texels_.width(), wrap_.s);
      const float* const other = step_y(x) > 0 ? below : above;
      const float a = own[x] + kBeside * (own[next] - own[x]), b = other[x] + kBeside * (other[next] - other[x]);
      points[x] = a + kBeside * (b - a);
    }
  }

  void lengthen() {
    auto& [px, py, pz] = points_.planes;
    for (std::size_t x = 0; x < px.size(); ++x) {
      const float length = points_.lengths[x], sum = std::sqrt(px[x] * px[x] + py[x] * py[x] + pz[x] * pz[x]);
      const bool cancels = sum <= 1e-6f * length;
      const float factor = length / std::max(cancels ? row_.lengths[x] : sum, 1e-30f);
      for (std::size_t p = 0; p < 3; ++p)
        points_.planes[p][x] = (cancels ? row_.planes[p][x] : points_.planes[p][x]) * factor;
    }
  }

  const PlaneStore& texels_;
  const MapWrap wrap_;
  const bool are_normals_;
  Row above_, row_, below_, points_;
};

PlaneStore points_of(const PlaneStore& texels, const MapWrap& wrap, bool are_normals, const SpillPolicy& spill,
                     int threads, Progress* progress) {
  PlaneStore points = make_plane_store(texels.width(), texels.height(), spill);
  points.set_shortened(texels.is_shortened());
  for_each_row_band(texels.height(), decoding_rows(texels.width(), spill), threads, progress,
                    [&](int, int begin, int end) { PointRows(texels, wrap, are_normals).make(begin, end, points); });
  return points;
}

}  // namespace

PlaneStore surface_normals(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                           Progress* progress) {
  return points_of(texels, wrap, true, spill, threads, progress);
}

PlaneStore surface_values(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                          Progress* progress) {
  return points_of(texels, wrap, false, spill, threads, progress);
}

}  // namespace multum
