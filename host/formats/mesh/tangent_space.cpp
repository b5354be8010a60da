// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/tangent_space.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

using Index = std::uint32_t;

struct VertexKey {
  std::array<std::uint32_t, 8> bits;
  bool operator==(const VertexKey&) const = default;
};

struct VertexKeyHash {
  std::size_t operator()(const VertexKey& key) const {
    std::size_t hash = 1469598103934665603u;
    for (const std::uint32_t word : key.bits) hash = (hash ^ word) * 1099511628211u;
    return hash;
  }
};

VertexKey key_of(const TriangleCorners& corners, std::size_t i) {
  const glm::vec3 &p = corners.positions[i], &n = corners.normals[i];
  const glm::vec2& uv = corners.uvs[i];
  const auto bits = [](float v) { return std::bit_cast<std::uint32_t>(v == 0.0f ? 0.0f : v); };  // -0 becomes 0
  return {{bits(p.x), bits(p.y), bits(p.z), bits(n.x), bits(n.y), bits(n.z), bits(uv.x), bits(uv.y)}};
}

// Returns the vertex number of each corner.
std::vector<Index> weld(const TriangleCorners& corners) {
  std::unordered_map<VertexKey, Index, VertexKeyHash> vertices;
  std::vector<Index> numbers;
  numbers.reserve(corners.positions.size());
  for (std::size_t i = 0; i < corners.positions.size(); ++i)
    numbers.push_back(vertices.try_emplace(key_of(corners, i), static_cast<Index>(vertices.size())).first->second);
  return numbers;
}

struct Face {
  glm::dvec3 tangent{0.0};  // unit vector; 0 if u does not change
  bool is_mirrored = false;
  bool has_area = true;  // true if the area in space is not 0; triangles without an area are ignored
};

Face face_of(const TriangleCorners& corners, std::size_t first) {
  const auto position = [&](std::size_t k) { return glm::dvec3(corners.positions[first + k]); };
  const auto uv = [&](std::size_t k) { return glm::dvec2(corners.uvs[first + k]); };
  const glm::dvec3 e1 = position(1) - position(0), e2 = position(2) - position(0);
  const glm::dvec2 d1 = uv(1) - uv(0), d2 = uv(2) - uv(0);
  const double area = d1.x * d2.y - d1.y * d2.x;
  Face face;
  face.is_mirrored = area < 0.0;
  face.has_area = glm::length(glm::cross(e1, e2)) > 0.0;
  const glm::dvec3 tangent = (area < 0.0 ? -1.0 : 1.0) * (d2.y * e1 - d1.y * e2);
  const double size = glm::length(tangent);
  if (area != 0.0 && size > 0.0 && std::isfinite(size)) face.tangent = tangent / size;
  return face;
}

// Disjoint sets of corners (union-find).
class Groups {
 public:
  explicit Groups(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), std::size_t{0}); }
  std::size_t find(std::size_t i) {
    while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) { parents_[std::max(find(a), find(b))] = std::min(find(a), find(b)); }

 private:
  std::vector<std::size_t> parents_;
};

bool is_directed(const Face& face) { return face.has_area && face.tangent != glm::dvec3(0.0); }

// Joins the corners of triangles that share an edge and its orientation, at both ends of the edge.
Groups join_at_edges(const std::vector<Index>& vertices, const std::vector<Face>& faces) {
  const auto next = [](std::size_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; };
  Groups groups(vertices.size());
  // Maps an edge's vertices and orientation to the corner of the first triangle at which the edge begins.
  std::map<std::array<Index, 3>, std::size_t> edges;
  for (std::size_t corner = 0; corner < vertices.size(); ++corner) {
    const Face& face = faces[corner / 3];
    if (!is_directed(face)) continue;
    const Index a = vertices[corner], b = vertices[next(corner)];
    const auto [found, is_new] =
        edges.try_emplace({std::min(a, b), std::max(a, b), face.is_mirrored ? Index{1} : Index{0}}, corner);
    if (is_new) continue;
    for (const std::size_t p : {corner, next(corner)})
      for (const std::size_t q : {found->second, next(found->second)})
        if (vertices[p] == vertices[q]) groups.join(p, q);
  }
  return groups;
}

glm::dvec3 across(const glm::dvec3& v, const glm::dvec3& normal) {
  const glm::dvec3 flat = v - normal * glm::dot(normal, v);
  const double size = glm::length(flat);
  return size > 1e-20 ? flat / size : glm::dvec3(0.0);
}

// Returns the angle between the two edges of a triangle at a corner, projected to the plane perpendicular to the
// corner's normal.
double angle_at(const TriangleCorners& corners, std::size_t corner) {
  const std::size_t first = corner - corner % 3;
  const glm::dvec3 at(corners.positions[corner]), normal(corners.normals[corner]);
  const glm::dvec3 to_next = across(glm::dvec3(corners.positions[first + (corner + 1) % 3]) - at, normal);
  const glm::dvec3 to_last = across(glm::dvec3(corners.positions[first + (corner + 2) % 3]) - at, normal);
  return std::acos(std::clamp(glm::dot(to_next, to_last), -1.0, 1.0));
}

}  // namespace

glm::vec3 any_orthogonal(const glm::vec3& n) {
  const glm::vec3 axis = std::abs(n.x) < 0.7f ? glm::vec3(1.0f, 0.0f, 0.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  return glm::normalize(axis - n * glm::dot(n, axis));
}

std::vector<glm::vec4> mikk_tangents(const TriangleCorners& corners) {
  const std::size_t count = corners.positions.size();
  MULTUM_CHECK(count % 3 == 0 && corners.normals.size() == count && corners.uvs.size() == count);
  const std::vector<Index> vertices = weld(corners);
  std::vector<Face> faces;
  for (std::size_t first = 0; first < count; first += 3) faces.push_back(face_of(corners, first));
  Groups groups = join_at_edges(vertices, faces);

  struct Sum {
    glm::dvec3 tangent{0.0};
    bool is_mirrored = false;
  };
  std::vector<Sum> sums(count);                       // one sum per group, at the group's first corner
  std::unordered_map<Index, std::size_t> directions;  // for each vertex, one group that has a direction
  for (std::size_t corner = 0; corner < count; ++corner) {
    const Face& face = faces[corner / 3];
    if (!is_directed(face)) continue;
    const std::size_t group = groups.find(corner);
    sums[group].tangent += angle_at(corners, corner) * across(face.tangent, glm::dvec3(corners.normals[corner]));
    sums[group].is_mirrored = face.is_mirrored;
    directions.try_emplace(vertices[corner], group);
  }
  std::vector<glm::vec4> tangents(count);
  for (std::size_t corner = 0; corner < count; ++corner) {
    const auto other = directions.find(vertices[corner]);
    const std::size_t group =
        is_directed(faces[corner / 3]) || other == directions.end() ? groups.find(corner) : other->second;
    const glm::dvec3 tangent = across(sums[group].tangent, glm::dvec3(corners.normals[corner]));
    tangents[corner] =
        glm::vec4(tangent == glm::dvec3(0.0) ? any_orthogonal(corners.normals[corner]) : glm::vec3(tangent),
                  sums[group].is_mirrored ? -1.0f : 1.0f);
  }
  return tangents;
}

}  // namespace multum
