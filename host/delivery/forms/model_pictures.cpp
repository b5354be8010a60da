// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/model_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::uint32_t kNothing = ~0u;
constexpr int kPictureSide = 240;   // pixels
constexpr int kSamplesPerSide = 8;  // samples per side of a pixel
// Half of the picture's side at distance 1, for a field of view of 45 degrees.
const double kPlaneHalf = std::tan(22.5 * std::numbers::pi / 180.0);
// Pixels are edges if, at their middle, the cosine between surface and view is below this value.
constexpr double kFacingMin = 0.02;

// Distances in radii of the model's bounding sphere. Each distant view has only a few pixels.
constexpr PicturedDistance kPicturedRadii[] = {{1.3, 2}, {2.5, 2}, {5.0, 3}, {10.0, 4}, {20.0, 8}, {40.0, 16}};

glm::dvec3 direction_of_side(int side) {
  if (side == 0) return glm::normalize(glm::dvec3(0.3, 0.1, 1.0));
  const double turn = 2.399963 * side, height = 0.35 + 0.3 * std::sin(1.7 * side);  // the golden angle
  return glm::normalize(glm::dvec3(std::sin(turn), height, std::cos(turn)));
}

}  // namespace

glm::dvec2 ModelPixel::grid_place(int i, int side) {
  const auto along = [&](int index) { return (index + 0.5) / side - 0.5; };
  return {along(i % side), along(i / side)};
}
std::size_t ModelPixel::sample_count() const { return flat_side > 0 ? size_of(flat_side * flat_side) : samples.size(); }
SurfacePoint ModelPixel::sample(std::size_t i) const {
  if (flat_side == 0) return samples[i];
  const glm::dvec2 at = grid_place(static_cast<int>(i), flat_side);
  return middle + along_x * at.x + along_y * at.y;
}

struct ModelPictures::View {
  double distance = 0.0;
  glm::dvec3 eye{0.0}, right{1.0, 0.0, 0.0}, up{0.0, 1.0, 0.0}, forward{0.0, 0.0, -1.0};
  double pixel = 1.0;                            // width of a pixel at distance 1
  int left = 0, top = 0, width = 0, height = 0;  // pixels of the picture, relative to its middle
  std::vector<std::uint32_t> triangles;          // triangle at each sample of these pixels

  std::size_t sample_at(int x, int y) const { return size_of(y) * size_of(width * kSamplesPerSide) + size_of(x); }

  // Returns the direction of the ray through a place of the picture. The place is given in pixels from the middle.
  glm::dvec3 ray(double x, double y) const { return forward + x * pixel * right - y * pixel * up; }
  // Projects a position. Returns its place in the picture, in pixels from the middle, and its depth.
  glm::dvec3 projected(const glm::dvec3& position) const {
    const glm::dvec3 seen = position - eye;
    const double depth = glm::dot(seen, forward), scale = 1.0 / (pixel * depth);
    return {scale * glm::dot(seen, right), -scale * glm::dot(seen, up), depth};
  }

  void look(const glm::dvec3& middle, const glm::dvec3& direction, double far, double radius, const PictureSet& set) {
    distance = far;
    pixel = set.pixel;
    eye = middle + far * direction;
    forward = -direction;
    right = glm::normalize(glm::cross(forward, glm::dvec3(0.0, 1.0, 0.0)));
    up = glm::cross(right, forward);
    // Uses the tangent cone of the sphere.
    const double reach = radius / std::sqrt(std::max(1e-9 * radius * radius, far * far - radius * radius)) / pixel;
    const double side = std::min(0.5 * set.side, std::ceil(reach) + 1.0);
    left = top = -static_cast<int>(side);
    width = height = 2 * static_cast<int>(side);
  }

  void draw(const TriangleMesh& mesh);
};

// Draws triangles with the depth of their planes. 1 / depth is linear over the picture.
void ModelPictures::View::draw(const TriangleMesh& mesh) {
  const int columns = width * kSamplesPerSide, rows = height * kSamplesPerSide;
  triangles.assign(size_of(columns) * size_of(rows), kNothing);
  std::vector<float> nearest(triangles.size(), 0.0f);  // 1 / depth
  std::vector<glm::dvec3> corners(mesh.positions.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = projected(glm::dvec3(mesh.positions[i]));
    corners[i].x = (corners[i].x - left) * kSamplesPerSide - 0.5;  // the middles of samples are at integers
    corners[i].y = (corners[i].y - top) * kSamplesPerSide - 0.5;
  }
  for (std::size_t t = 0; 3 * t + 2 < mesh.indices.size(); ++t) {
    const glm::dvec3 &a = corners[mesh.indices[3 * t]], &b = corners[mesh.indices[3 * t + 1]],
                     &c = corners[mesh.indices[3 * t + 2]];
    if (std::min({a.z, b.z, c.z}) <= 0.0)
      continue;  // can happen only because of rounding, since the eye is outside
                 // the sphere
    const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(std::abs(area) > 1e-12)) continue;
    const auto bound = [](double value, int count) { return static_cast<int>(std::clamp(value, 0.0, 1.0 * count)); };
    const int x0 = bound(std::ceil(std::min({a.x, b.x, c.x})), columns),
              x1 = bound(std::floor(std::max({a.x, b.x, c.x})) + 1.0, columns),
              y0 = bound(std::ceil(std::min({a.y, b.y, c.y})), rows),
              y1 = bound(std::floor(std::max({a.y, b.y, c.y})) + 1.0, rows);
    // Weights of b and c, and 1 / depth, are linear over the picture.
    const glm::dvec2 step_b = glm::dvec2(c.y - a.y, a.x - c.x) / area, step_c = glm::dvec2(a.y - b.y, b.x - a.x) / area;
    const double near_a = 1.0 / a.z, near_b = 1.0 / b.z - near_a, near_c = 1.0 / c.z - near_a;
    for (int y = y0; y < y1; ++y) {
      double weight_b = (x0 - a.x) * step_b.x + (y - a.y) * step_b.y;
      double weight_c = (x0 - a.x) * step_c.x + (y - a.y) * step_c.y;
      std::size_t at = sample_at(x0, y);
      for (int x = x0; x < x1; ++x, ++at, weight_b += step_b.x, weight_c += step_c.x) {
        if (weight_b < 0.0 || weight_c < 0.0 || weight_b + weight_c > 1.0) continue;
        const auto closeness = static_cast<float>(near_a + weight_b * near_b + weight_c * near_c);
        if (closeness <= nearest[at]) continue;
        nearest[at] = closeness;
        triangles[at] = static_cast<std::uint32_t>(t);
      }
    }
  }
}

namespace {

// Intersects rays with a triangle's plane.
class PictureTriangle {
 public:
  PictureTriangle(const TriangleMesh& mesh, std::uint32_t triangle, const PicturedSurface& surface)
      : mesh_(mesh), surface_(surface) {
    for (std::size_t k = 0; k < 3; ++k) index_[k] = mesh.indices[3 * size_of(triangle) + k];
    const auto corner = [&](std::size_t k) { return glm::dvec3(mesh.positions[index_[k]]); };
    origin_ = corner(0);
    edge_b_ = corner(1) - origin_;
    edge_c_ = corner(2) - origin_;
  }

  // Intersects as in Möller and Trumbore 1997. Returns nullopt if the ray is parallel to the plane.
  std::optional<SurfacePoint> at(const glm::dvec3& eye, const glm::dvec3& ray) const {
    const glm::dvec3 p = glm::cross(ray, edge_c_), s = eye - origin_, q = glm::cross(s, edge_b_);
    const double determinant = glm::dot(edge_b_, p);
    if (std::abs(determinant) < 1e-300) return std::nullopt;
    const double b = glm::dot(s, p) / determinant, c = glm::dot(ray, q) / determinant;
    const std::array<double, 3> weights = {1.0 - b - c, b, c};
    SurfacePoint made{glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec3(0.0), glm::dvec2(0.0)};
    double handedness = 1.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t i = index_[k];
      made.position += weights[k] * glm::dvec3(mesh_.positions[i]);
      made.normal += weights[k] * glm::dvec3(mesh_.normals[i]);
      made.tangent += weights[k] * glm::dvec3(mesh_.tangents[i]);
      made.place += weights[k] * glm::dvec2(mesh_.uvs[i]);
      handedness = static_cast<double>(mesh_.tangents[i].w);
    }
    made.place = surface_.place_of_uv(made.place);
    const double length = glm::length(made.normal);
    if (!(length > 1e-9) || !std::isfinite(length)) return std::nullopt;
    made.normal /= length;
    made.tangent -= glm::dot(made.tangent, made.normal) * made.normal;
    const double along = glm::length(made.tangent);
    if (!(along > 1e-9)) return std::nullopt;
    made.tangent /= along;
    made.bitangent = handedness * glm::cross(made.normal, made.tangent);
    // Back faces are drawn as if they faced the eye.
    if (glm::dot(glm::cross(edge_b_, edge_c_), ray) > 0.0 && glm::dot(made.normal, ray) > 0.0) {
      made.normal = -made.normal;
      made.tangent = -made.tangent;
      made.bitangent = -made.bitangent;
    }
    return made;
  }

 private:
  const TriangleMesh& mesh_;
  const PicturedSurface& surface_;
  std::array<std::uint32_t, 3> index_{};
  glm::dvec3 origin_, edge_b_, edge_c_;
};

}  // namespace

PictureSet PictureSet::of_all_sizes(double radius) {
  PictureSet made{{}, 2.0 * kPlaneHalf / kPictureSide, kPictureSide};
  for (const PicturedDistance& far : kPicturedRadii) made.distances.push_back({far.distance * radius, far.side_count});
  return made;
}

BoundingSphere BoundingSphere::of(const TriangleMesh& mesh) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
  for (const glm::vec3& position : mesh.positions) {
    low = glm::min(low, glm::dvec3(position));
    high = glm::max(high, glm::dvec3(position));
  }
  const glm::dvec3 middle = 0.5 * (low + high);
  double radius = 0.0;
  for (const glm::vec3& position : mesh.positions)
    radius = std::max(radius, glm::length(glm::dvec3(position) - middle));
  return {middle, radius > 0.0 && std::isfinite(radius) ? radius : 0.0};
}

ModelPictures::ModelPictures(const TriangleMesh& mesh, const PictureSet& set, int threads, Progress* progress)
    : mesh_(mesh) {
  material_of_.assign(mesh.indices.size() / 3, 0);
  for (const MeshPart& part : mesh.parts)
    std::fill_n(material_of_.begin() + part.first_index / 3, part.index_count / 3,
                static_cast<std::uint32_t>(part.material_index));
  const auto [middle, radius] = BoundingSphere::of(mesh);
  if (radius == 0.0) return;
  for (const PicturedDistance& far : set.distances)
    for (int side = 0; side < far.side_count; ++side)
      views_.emplace_back().look(middle, direction_of_side(side), far.distance, radius, set);
  for_each_row_band(static_cast<int>(views_.size()), 1, threads, progress,
                    [&](int view, int, int) { views_[size_of(view)].draw(mesh_); });
}

ModelPictures::~ModelPictures() = default;

std::vector<ModelPicture> ModelPictures::of(const PicturedSurface& surface, std::size_t pixel_max) const {
  std::vector<ModelPicture> made;
  for (const View& view : views_)
    if (std::optional<ModelPicture> picture = picture_of(view, surface, pixel_max)) made.push_back(std::move(*picture));
  return made;
}

std::vector<ModelPicture> ModelPictures::of(const PicturedSurface& surface, std::size_t pixel_max,
                                            double distance) const {
  std::vector<ModelPicture> made;
  for (const View& view : views_)
    if (view.distance == distance)
      if (std::optional<ModelPicture> picture = picture_of(view, surface, pixel_max))
        made.push_back(std::move(*picture));
  return made;
}

std::optional<ModelPicture> ModelPictures::picture_of(const View& view, const PicturedSurface& surface,
                                                      std::size_t pixel_max) const {
  const auto is_ours = [&](std::uint32_t triangle) {
    return triangle != kNothing && std::find(surface.materials.begin(), surface.materials.end(),
                                             static_cast<int>(material_of_[triangle])) != surface.materials.end();
  };
  constexpr int kSampleCount = kSamplesPerSide * kSamplesPerSide, kMiddle = kSamplesPerSide / 2;
  std::vector<glm::ivec2> covered;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      int count = 0;
      for (int s = 0; s < kSampleCount; ++s)
        count += is_ours(view.triangles[view.sample_at(x * kSamplesPerSide + s % kSamplesPerSide,
                                                       y * kSamplesPerSide + s / kSamplesPerSide)])
                     ? 1
                     : 0;
      const std::uint32_t at_middle =
          view.triangles[view.sample_at(x * kSamplesPerSide + kMiddle, y * kSamplesPerSide + kMiddle)];
      if (2 * count >= kSampleCount && is_ours(at_middle)) covered.emplace_back(x, y);
    }
  if (covered.empty()) return std::nullopt;
  ModelPicture picture;
  picture.distance = view.distance;
  picture.eye = view.eye;
  picture.to_view = glm::transpose(glm::dmat3(view.right, view.up, -view.forward));
  const std::size_t count = std::min(pixel_max, covered.size());
  for (std::size_t i = 0; i < count; ++i) {
    const glm::ivec2 pixel = covered[(2 * i + 1) * covered.size() / (2 * count)];
    const double x = view.left + pixel.x + 0.5, y = view.top + pixel.y + 0.5;
    const auto triangle_at = [&](int column, int row) {
      return view.triangles[view.sample_at(pixel.x * kSamplesPerSide + column, pixel.y * kSamplesPerSide + row)];
    };
    const PictureTriangle middle(mesh_, triangle_at(kMiddle, kMiddle), surface);
    const auto point = middle.at(view.eye, view.ray(x, y)), right = middle.at(view.eye, view.ray(x + 0.5, y)),
               left = middle.at(view.eye, view.ray(x - 0.5, y)), below = middle.at(view.eye, view.ray(x, y + 0.5)),
               above = middle.at(view.eye, view.ray(x, y - 0.5));
    if (!point || !right || !left || !below || !above) continue;
    if (glm::dot(point->normal, glm::normalize(view.eye - point->position)) < kFacingMin) continue;
    ModelPixel& pixel_made = picture.pixels.emplace_back(ModelPixel{*point, *right - *left, *below - *above, {}, 0});
    pixel_made.samples.reserve(kSampleCount);
    for (int s = 0; s < kSampleCount; ++s) {
      const std::uint32_t triangle = triangle_at(s % kSamplesPerSide, s / kSamplesPerSide);
      if (!is_ours(triangle)) continue;
      const glm::dvec2 at = ModelPixel::grid_place(s, kSamplesPerSide);
      const auto sample = PictureTriangle(mesh_, triangle, surface).at(view.eye, view.ray(x + at.x, y + at.y));
      if (sample) pixel_made.samples.push_back(*sample);
    }
    if (pixel_made.samples.empty()) picture.pixels.pop_back();
  }
  return picture;
}

TriangleMesh textured_sphere() {
  constexpr std::uint32_t kColumns = 96, kRows = 48;
  TriangleMesh made;
  for (std::uint32_t row = 0; row <= kRows; ++row)
    for (std::uint32_t column = 0; column <= kColumns; ++column) {
      const float u = static_cast<float>(column) / kColumns, v = static_cast<float>(row) / kRows;
      const float turn = 2.0f * std::numbers::pi_v<float> * u, rise = std::numbers::pi_v<float> * (v - 0.5f);
      const glm::vec3 normal(std::cos(rise) * std::sin(turn), std::sin(rise), std::cos(rise) * std::cos(turn));
      made.positions.push_back(normal);
      made.normals.push_back(normal);
      made.tangents.emplace_back(std::cos(turn), 0.0f, -std::sin(turn), 1.0f);
      made.uvs.emplace_back(2.0f * u, v);
    }
  for (std::uint32_t row = 0; row < kRows; ++row)
    for (std::uint32_t column = 0; column < kColumns; ++column) {
      const std::uint32_t corner = row * (kColumns + 1) + column, above = corner + kColumns + 1;
      for (const std::uint32_t i : {corner, corner + 1, above + 1, corner, above + 1, above}) made.indices.push_back(i);
    }
  made.parts = {{"", 0, 0, static_cast<std::uint32_t>(made.indices.size())}};
  return made;
}

}  // namespace multum
