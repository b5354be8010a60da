// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/plane_resize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/delivery/forms/texture_lookups.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// The two texels next to a place and the share of the second texel.
struct Between {
  int first, second;
  float share;
};

std::vector<Between> places(int before, int after, WrapMode wrap) {
  std::vector<Between> made(size_of(after));
  for (int i = 0; i < after; ++i) {
    // Texel centres are at half-integer positions.
    const double at = (i + 0.5) * before / after - 0.5, low = std::floor(at);
    made[size_of(i)] = {wrapped_texel(static_cast<int>(low), before, wrap),
                        wrapped_texel(static_cast<int>(low) + 1, before, wrap), static_cast<float>(at - low)};
  }
  return made;
}

using PlaneRows = std::array<std::vector<float>, 3>;

PlaneRows sized_rows(std::size_t count) {
  PlaneRows rows;
  for (std::vector<float>& row : rows) row.resize(count);
  return rows;
}

std::array<float*, 3> pointers(PlaneRows& rows) { return {rows[0].data(), rows[1].data(), rows[2].data()}; }

}  // namespace

PlaneStore enlarged_planes(const PlaneStore& planes, const ResizeSettings& settings,
                           const std::function<void(float& a, float& b, float& c)>& finish) {
  PlaneStore made = make_plane_store(settings.width, settings.height, settings.spill);
  const std::vector<Between> columns = places(planes.width(), settings.width, settings.wrap_s);
  const std::vector<Between> rows = places(planes.height(), settings.height, settings.wrap_t);
  for_each_row_band(settings.height, kRowsPerBand, settings.threads, [&](int, int begin, int end) {
    PlaneRows first = sized_rows(size_of(planes.width())), second = first, row = sized_rows(columns.size());
    for (int y = begin; y < end; ++y) {
      const Between& at = rows[size_of(y)];
      planes.read_rows(at.first, 1, pointers(first));
      planes.read_rows(at.second, 1, pointers(second));
      for (std::size_t p = 0; p < row.size(); ++p)
        for (std::size_t x = 0; x < columns.size(); ++x) {
          const auto along = [&](const std::vector<float>& of) {
            const float a = of[size_of(columns[x].first)], b = of[size_of(columns[x].second)];
            return a + columns[x].share * (b - a);
          };
          const float upper = along(first[p]), lower = along(second[p]);
          row[p][x] = upper + at.share * (lower - upper);
        }
      for (std::size_t x = 0; x < columns.size(); ++x) finish(row[0][x], row[1][x], row[2][x]);
      made.write_rows(y, 1, {row[0].data(), row[1].data(), row[2].data()});
    }
  });
  return made;
}

}  // namespace multum
