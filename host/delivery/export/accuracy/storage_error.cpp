// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/storage_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/delivery/export/accuracy/lobe_shading.h"
#include "host/delivery/export/baked_lobes.h"
#include "host/delivery/export/one_lobe_fit.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

// The number of places per level, of views per place and of lights per view. If the same error is measured with two
// sets of this size, the results differ by about 5 %.
constexpr int kRows = 96, kPlacesPerRow = 16, kViews = 2, kLights = 8;
constexpr double kViewAngleMax = 70.0;  // angle to the map's z axis, degrees
constexpr double kAlbedo = 0.5;         // albedo where the surface is not metal
// The ambient light relative to unit lights. Both cause the same amount of scattered light. Real pictures contain both
// kinds of light.
constexpr double kAmbient = 0.5 / std::numbers::pi;
// The relative L1 error of a picture that is drawn with exact textures. This error is due to edges and sampling. In
// docs/evidence/GLTF_EXAMPLE.md, the error is 1 to 2 % where level 0 is visible. The medians at distances of 5, 25 and
// 50 m, which show about levels 3, 5 and 6, are 9, 14 and 20 %.
constexpr double kFinestPictureError = 0.012, kPictureErrorPerLevel = 0.03;
constexpr double kDielectric = 0.04, kMetal = 0.9;  // reflectance at normal incidence

// The values that a sampler returns at a place.
struct SampledSurface {
  glm::dvec3 normal{0.0, 0.0, 1.0};  // unit vector
  double alpha = 1.0, metalness = 0.0;
};

double diffuse_share(double metalness) { return (1.0 - metalness) * kAlbedo / std::numbers::pi; }

// Schlick's approximation.
double fresnel(double metalness, double view_half) {
  const double f0 = kDielectric + (kMetal - kDielectric) * metalness;
  return f0 + (1.0 - f0) * std::pow(1.0 - std::clamp(view_half, 0.0, 1.0), 5.0);
}

glm::dvec3 square_to(const glm::dvec3& n, double a, double b) {
  const glm::dvec3 x = tangent_about(n);
  return glm::normalize(a * x + b * glm::cross(n, x) + n);
}

// Draws directions of lights, half of them from the surface's highlights and half from all directions. Each light has
// the weight that it needs in an integral over all directions.
LightSet lights_of(const SampledSurface& surface, const glm::dvec3& view, SplitMix64& random) {
  LightSet set;
  set.view = view;
  for (int k = 0; k < kLights; ++k) {
    const double u = 1.0 - random.uniform(), turn = 2.0 * std::numbers::pi * random.uniform();
    glm::dvec3 light;
    if (k % 2 == 0) {
      const double slope = surface.alpha * std::sqrt((1.0 - u) / u);
      const glm::dvec3 half = square_to(surface.normal, slope * std::cos(turn), slope * std::sin(turn));
      light = 2.0 * glm::dot(view, half) * half - view;
    } else {
      const double sine = std::sqrt(1.0 - u * u);
      light = {sine * std::cos(turn), sine * std::sin(turn), u};
    }
    if (light.z <= 1e-6) continue;
    set.add(light);
    const glm::dvec3 half(set.hx.back(), set.hy.back(), set.hz.back());
    const double nh = glm::dot(surface.normal, half), a2 = surface.alpha * surface.alpha;
    const double d = nh * nh * (a2 - 1.0) + 1.0, vh = std::max(glm::dot(view, half), 1e-6);
    const double density = nh > 0.0 ? a2 * nh / (std::numbers::pi * d * d * 4.0 * vh) : 0.0;
    set.share.back() = 2.0 / (kLights * (density + 0.5 / std::numbers::pi));
  }
  return set;
}

glm::dvec3 random_view(SplitMix64& random) {
  const double polar = kViewAngleMax * std::numbers::pi / 180.0 * std::sqrt(random.uniform());
  const double turn = 2.0 * std::numbers::pi * random.uniform();
  return {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
}

// The light that a surface reflects if it is lit by unit lights. Highlights are D V (n . l), without the Fresnel
// factor.
struct Reflection {
  double metalness = 0.0;
  glm::dvec3 diffuse_normal{0.0, 0.0, 1.0};  // length 0 to 1
  std::vector<double> highlights;

  // Returns the reflection of light `i` plus the ambient light, most of which comes from above.
  double light(const LightSet& set, std::size_t i) const {
    const glm::dvec3 l(set.x[i], set.y[i], set.z[i]), h(set.hx[i], set.hy[i], set.hz[i]);
    const double view_cosine = glm::dot(diffuse_normal, set.view);
    const glm::dvec3 mirrored = 2.0 * view_cosine * diffuse_normal - set.view;
    const double around = std::numbers::pi * diffuse_share(metalness) * (1.0 + diffuse_normal.z) +
                          fresnel(metalness, view_cosine) * (1.0 + mirrored.z);
    return diffuse_share(metalness) * std::max(glm::dot(diffuse_normal, l), 0.0) +
           fresnel(metalness, glm::dot(set.view, h)) * highlights[i] + 0.5 * kAmbient * around;
  }
};

Reflection reflection_of(const SampledSurface& surface, const LightSet& set) {
  Reflection made{surface.metalness, surface.normal, {}};
  highlights(set, GgxLobe::isotropic(surface.normal, surface.alpha), made.highlights);
  return made;
}

// The sums of differences, and the sums of the values to which the differences are relative.
struct DifferenceSum {
  double difference = 0.0, total = 0.0;

  void add(const LightSet& set, const Reflection& exact, const Reflection& stored) {
    for (std::size_t i = 0; i < set.size(); ++i) {
      const double value = exact.light(set, i);
      difference += set.share[i] * std::abs(stored.light(set, i) - value);
      total += set.share[i] * value;
    }
  }
  // Returns the amount by which storage increases a picture's error at this level. The errors of storage and of the
  // picture are independent.
  double added(int level) const {
    const double own = total > 0.0 ? difference / total : 0.0;
    const double picture = kFinestPictureError + kPictureErrorPerLevel * level;
    return std::hypot(picture, own) - picture;
  }
};

// The four texels that a sampler reads in a level, and their weights.
struct Footprint {
  int rows[2], columns[2];
  double weights[4];
};

// Returns the footprint at (x, y), 0 to 1 over the level. Maps repeat beyond their borders.
Footprint footprint(int width, int height, double x, double y) {
  const double across = x * width - 0.5, down = y * height - 0.5, part_x = across - std::floor(across);
  const double part_y = down - std::floor(down);
  const auto wrapped = [](double at, int size) { return (static_cast<int>(at) + size) % size; };
  const int left = wrapped(std::floor(across), width), top = wrapped(std::floor(down), height);
  return {{top, (top + 1) % height},
          {left, (left + 1) % width},
          {(1.0 - part_x) * (1.0 - part_y), part_x * (1.0 - part_y), (1.0 - part_x) * part_y, part_x * part_y}};
}

// Samples one level of a material. The rows that were read last stay in memory.
class SampledLevel {
 public:
  SampledLevel(const MaterialLevels& levels, int level)
      : levels_(levels),
        level_(level),
        width_(mip_level_size(levels.normal->width(), level)),
        height_(mip_level_size(levels.normal->height(), level)) {}

  /// Returns the filtered normal, then roughness and metalness.
  std::array<double, 5> at(double x, double y) {
    const Footprint place = footprint(width_, height_, x, y);
    if (place.rows[0] != row_) read(place);
    std::array<double, 5> sum{};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = 4 * (k / 2 * size_of(width_) + size_of(place.columns[k % 2]));
      const double weight = place.weights[k];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * (normal_[i + c] / 127.5 - 1.0);
      sum[3] += weight * (surface_.empty() ? levels_.roughness : surface_[i + 1] / 255.0);
      sum[4] += weight * (surface_.empty() ? levels_.metalness : surface_[i + 2] / 255.0);
    }
    return sum;
  }

 private:
  void read(const Footprint& place) {
    const auto two_rows = [&](const LevelFile& file) {
      std::vector<std::uint8_t> rows = file.read_rows(level_, place.rows[0], 1);
      const std::vector<std::uint8_t> next = file.read_rows(level_, place.rows[1], 1);
      rows.insert(rows.end(), next.begin(), next.end());
      return rows;
    };
    normal_ = two_rows(*levels_.normal);
    if (levels_.surface != nullptr) surface_ = two_rows(*levels_.surface);
    row_ = place.rows[0];
  }

  const MaterialLevels levels_;
  const int level_, width_, height_;
  int row_ = -1;
  std::vector<std::uint8_t> normal_, surface_;
};

// Samples midway between two levels.
class SampledMaterial {
 public:
  SampledMaterial(const MaterialLevels& levels, int level)
      : finer_(levels, level), coarser_(levels, std::min(level + 1, levels.normal->level_count() - 1)) {}

  SampledSurface at(double x, double y) {
    const std::array<double, 5> a = finer_.at(x, y), b = coarser_.at(x, y);
    const glm::dvec3 n(a[0] + b[0], a[1] + b[1], a[2] + b[2]);
    const double length = glm::length(n), roughness = 0.5 * (a[3] + b[3]);
    return {length > 1e-6 ? n / length : glm::dvec3(0.0, 0.0, 1.0), std::max(kAlphaMin, roughness * roughness),
            0.5 * (a[4] + b[4])};
  }

 private:
  SampledLevel finer_, coarser_;
};

// Calls `look` for places (x, y) from 0 to 1. Rows are spread over the map, and places are spread over each row.
template <typename Look>
void each_place(SplitMix64& random, const Look& look) {
  for (int row = 0; row < kRows; ++row) {
    const double y = 0.5 + 0.7548776662466927 * row;
    for (int k = 0; k < kPlacesPerRow; ++k) look((k + random.uniform()) / kPlacesPerRow, y - std::floor(y));
  }
}

double level_error(const MaterialLevels& exact, const MaterialLevels& stored, int level) {
  SampledMaterial one(exact, level), other(stored, level);
  SplitMix64 random(split_mix(size_of(level)));
  DifferenceSum sum;
  each_place(random, [&](double x, double y) {
    const SampledSurface right = one.at(x, y), kept = other.at(x, y);
    for (int v = 0; v < kViews; ++v) {
      const LightSet set = lights_of(right, random_view(random), random);
      sum.add(set, reflection_of(right, set), reflection_of(kept, set));
    }
  });
  return sum.added(level);
}

// Returns the lobes at a place between two levels. Amplitudes are scaled to a sum of 1.
std::vector<glm::dvec4> lobes_at(const LobeLevel& finer, const LobeLevel& coarser, double x, double y) {
  std::vector<glm::dvec4> lobes(finer.lobes->size(), glm::dvec4(0.0));
  double sum = 0.0;
  for (const LobeLevel* level : {&finer, &coarser}) {
    const Footprint place = footprint(level->width, level->height, x, y);
    for (std::size_t j = 0; j < lobes.size(); ++j)
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t i = size_of(place.rows[k / 2]) * size_of(level->width) + size_of(place.columns[k % 2]);
        const glm::dvec4 part = place.weights[k] * glm::dvec4((*level->lobes)[j][i]);
        lobes[j] += part, sum += part.w;
      }
  }
  for (glm::dvec4& lobe : lobes) lobe /= std::max(sum, 1e-6);
  return lobes;
}

Reflection reflection_of(const std::vector<glm::dvec4>& lobes, const LobeSurface& surface, const LightSet& set) {
  glm::dvec4 sum(0.0);
  for (const glm::dvec4& lobe : lobes) sum += lobe;
  Reflection made{surface.metalness, glm::dvec3(sum), {}};
  lobe_highlights(set, lobes, std::max(kAlphaMin, surface.roughness * surface.roughness), made.highlights);
  return made;
}

}  // namespace

StorageError storage_error(const MaterialLevels& exact, const MaterialLevels& stored) {
  StorageError worst;
  for (int level = 0; level < exact.normal->level_count(); ++level)
    worst.take(level_error(exact, stored, level), level);
  return worst;
}

LobeSurface mean_surface(const MaterialLevels& levels) {
  SampledLevel finest(levels, 0);
  SplitMix64 random(split_mix(0));
  LobeSurface sum{0.0, 0.0};
  each_place(random, [&](double x, double y) {
    const std::array<double, 5> texel = finest.at(x, y);
    sum.roughness += texel[3] / (kRows * kPlacesPerRow);
    sum.metalness += texel[4] / (kRows * kPlacesPerRow);
  });
  return sum;
}

StorageError lobe_storage_error(const std::vector<LobeLevel>& exact, const std::vector<LobeLevel>& stored,
                                const LobeSurface& surface) {
  StorageError worst;
  for (std::size_t l = 0; l < exact.size(); ++l) {
    const std::size_t next = std::min(l + 1, exact.size() - 1);
    SplitMix64 random(split_mix(l));
    DifferenceSum sum;
    each_place(random, [&](double x, double y) {
      const std::vector<glm::dvec4> right = lobes_at(exact[l], exact[next], x, y);
      const std::vector<glm::dvec4> kept = lobes_at(stored[l], stored[next], x, y);
      glm::dvec4 mean(0.0);
      for (const glm::dvec4& lobe : right) mean += lobe;
      const double length = glm::length(glm::dvec3(mean));
      if (!(length > 1e-6)) return;
      // Samples lights according to the highlights of all lobes together.
      const double alpha = std::sqrt(std::pow(surface.roughness, 4.0) + 2.0 * std::max(1.0 - length, 0.0));
      const SampledSurface together{glm::dvec3(mean) / length, std::clamp(alpha, kAlphaMin, 1.0), surface.metalness};
      for (int v = 0; v < kViews; ++v) {
        const LightSet set = lights_of(together, random_view(random), random);
        sum.add(set, reflection_of(right, surface, set), reflection_of(kept, surface, set));
      }
    });
    worst.take(sum.added(static_cast<int>(l) + 1), static_cast<int>(l));  // level 0 is in the normal map
  }
  return worst;
}

}  // namespace multum
