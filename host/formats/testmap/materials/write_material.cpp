// SPDX-License-Identifier: Apache-2.0
// Writes the maps of a material. Slopes are central differences of the heights.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "host/formats/image/colour_map.h"
#include "host/formats/image/files/png_writer.h"
#include "host/formats/testmap/materials/test_material.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr int kMaterialRows = 32;  // rows per band

std::uint16_t code_of(double share) {
  return static_cast<std::uint16_t>(std::lround(65535.0 * std::clamp(share, 0.0, 1.0)));
}

struct Codes {
  std::vector<std::uint16_t> normals, albedo, surface;
};

// Rows of points, each with a point more at both ends.
class PointRows {
 public:
  PointRows(const TestMaterial& material, int size, int first, int count) : size_(size), first_(first) {
    points_.resize(size_of(size + 2) * size_of(count));
    for_each_item(count, 0, [&](int i) {
      for (int x = -1; x <= size; ++x) point(x, first + i) = material.at((x + 0.5) / size, (first + i + 0.5) / size);
    });
  }
  MaterialPoint& point(int x, int y) { return points_[size_of(y - first_) * size_of(size_ + 2) + size_of(x + 1)]; }

 private:
  const int size_, first_;
  std::vector<MaterialPoint> points_;
};

Codes coded_rows(const TestMaterial& material, int size, int first, int count, GreenAxis green) {
  PointRows rows(material, size, first - 1, count + 2);
  Codes made;
  for (std::vector<std::uint16_t>* one : {&made.normals, &made.albedo, &made.surface})
    one->resize(3 * size_of(size) * size_of(count));
  for_each_item(count, 0, [&](int i) {
    const int y = first + i;
    std::size_t at = 3 * size_of(size) * size_of(i);
    for (int x = 0; x < size; ++x, at += 3) {
      const MaterialPoint& here = rows.point(x, y);
      const glm::dvec2 slope(0.5 * size * (rows.point(x + 1, y).height - rows.point(x - 1, y).height),
                             0.5 * size * (rows.point(x, y - 1).height - rows.point(x, y + 1).height));
      glm::dvec3 normal = glm::normalize(glm::dvec3(-(slope + here.slope), 1.0));
      if (green == GreenAxis::kDown) normal.y = -normal.y;
      const double surface[3] = {1.0, here.roughness, here.metalness};
      for (int c = 0; c < 3; ++c) {
        made.normals[at + size_of(c)] = code_of(0.5 + 0.5 * normal[c]);
        made.albedo[at + size_of(c)] = code_of(srgb_from_linear(here.colour[c]));
        made.surface[at + size_of(c)] = code_of(surface[c]);
      }
    }
  });
  return made;
}

}  // namespace

std::unique_ptr<TestMaterial> make_material(MaterialKind kind, std::uint64_t seed) {
  switch (kind) {
    case MaterialKind::kHammered: return make_hammered(seed);
    case MaterialKind::kDenim: return make_denim(seed);
    case MaterialKind::kBricks: return make_bricks(seed);
    case MaterialKind::kCarPaint: return make_car_paint(seed);
    case MaterialKind::kWater: return make_water(seed);
  }
  return nullptr;
}

void write_material(MaterialKind kind, int size, std::uint64_t seed, const std::string& prefix, GreenAxis green) {
  const std::unique_ptr<TestMaterial> material = make_material(kind, seed);
  Png16Writer normals(prefix + "_normal.png", size, size, "Linear"), albedo(prefix + "_albedo.png", size, size, "sRGB"),
      surface(prefix + "_orm.png", size, size, "Linear");
  for (int row = 0; row < size; row += kMaterialRows) {
    const int count = std::min(size - row, kMaterialRows);
    const Codes codes = coded_rows(*material, size, row, count, green);
    for_each_item(3, 3, [&](int item) {
      if (item == 0) normals.write_rows(count, codes.normals.data());
      else if (item == 1) albedo.write_rows(count, codes.albedo.data());
      else surface.write_rows(count, codes.surface.data());
    });
  }
  for (Png16Writer* file : {&normals, &albedo, &surface}) file->finish();
}

}  // namespace multum
