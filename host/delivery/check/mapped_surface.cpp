// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/check/mapped_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <utility>

#include "host/delivery/forms/model_pictures.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/delivery/gltf/source_fit.h"
#include "host/delivery/gltf/source_forms.h"
#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

const MosaicSettings kMosaic;

// The triangles of some materials.
class MappedTriangles {
 public:
  MappedTriangles(const TriangleMesh& mesh, const std::vector<int>& materials, const TextureCoordinates& coordinates) {
    for (const MeshPart& part : mesh.parts) {
      if (std::find(materials.begin(), materials.end(), part.material_index) == materials.end()) continue;
      for (std::uint32_t i = part.first_index; i + 2 < part.first_index + part.index_count; i += 3) {
        const auto corner = [&](std::uint32_t k) { return mesh.indices[i + k]; };
        const auto position = [&](std::uint32_t k) { return glm::dvec3(mesh.positions[corner(k)]); };
        const auto place = [&](std::uint32_t k) {
          return place_in_image(coordinates, glm::dvec2(mesh.uvs[corner(k)]));
        };
        const glm::dvec2 a = place(1) - place(0), b = place(2) - place(0);
        const double area = 0.5 * glm::length(glm::cross(position(1) - position(0), position(2) - position(0)));
        if (!(area > 0.0) || !std::isfinite(area)) continue;
        area_ += area;
        image_area_ += 0.5 * std::abs(a.x * b.y - a.y * b.x);
        middles_.push_back((place(0) + place(1) + place(2)) / 3.0);
        areas_.push_back(area_);
      }
    }
  }

  bool empty() const { return areas_.empty() || !(image_area_ > 0.0) || !std::isfinite(image_area_); }
  /// Returns texels per unit of length, for an image of this size.
  double density(int width, int height) const { return std::sqrt(image_area_ * width * height / area_); }
  /// Returns the middle of a triangle, from 0 to 1 across the image. Large triangles are chosen more often.
  glm::dvec2 middle(double random) const {
    const auto at = std::lower_bound(areas_.begin(), areas_.end(), random * area_);
    const glm::dvec2 place = middles_[std::min(static_cast<std::size_t>(at - areas_.begin()), middles_.size() - 1)];
    return place - glm::floor(place);
  }

 private:
  double area_ = 0.0, image_area_ = 0.0;
  std::vector<glm::dvec2> middles_;
  std::vector<double> areas_;  // cumulative
};

// Takes each block from the middle of a triangle. A side that is not longer than the mosaic is one block.
MosaicCuts cuts_at(const MappedTriangles& triangles, int width, int height) {
  MosaicCuts cuts = mosaic_cuts(width, height, kMosaic);
  SplitMix64 random(kMosaic.seed);
  const int rows = static_cast<int>(cuts.blocks.size()), columns = static_cast<int>(cuts.blocks.front().size());
  const glm::ivec2 block(cuts.width / columns, cuts.height / rows);
  const auto first = [](double place, int size, int side) {
    return std::clamp(static_cast<int>(place * size) - side / 2, 0, size - side);
  };
  for (std::vector<glm::ivec2>& row : cuts.blocks)
    for (glm::ivec2& at : row) {
      const glm::dvec2 middle = triangles.middle(random.uniform());
      at = {first(middle.x, width, block.x), first(middle.y, height, block.y)};
    }
  return cuts;
}

// Moves roughness from the lengths of normals to the material (host/formats/image/material_maps.h).
void divide_by_length(GainSurface& surface) {
  const int width = surface.normals.width(), height = surface.normals.height();
  std::array<std::vector<float>, 3> planes = surface.normals.take_planes();
  std::vector<float> alpha2(planes[0].size()), one(planes[0].size(), 1.0f);
  for (std::size_t i = 0; i < alpha2.size(); ++i) {
    const float length = std::hypot(planes[0][i], planes[1][i], planes[2][i]);
    alpha2[i] = std::clamp(2.0f * (1.0f - length), 0.0f, 1.0f);
    for (std::vector<float>& plane : planes) plane[i] /= std::max(length, 1e-6f);
  }
  surface.normals = PlaneStore(width, height);
  surface.normals.write_rows(0, height, {planes[0].data(), planes[1].data(), planes[2].data()});
  surface.material.emplace(width, height);
  surface.material->write_rows(0, height, {alpha2.data(), one.data(), one.data()});
  surface.has_roughness = true;
}

// A model, drawn from the distances at which the eye is outside of it.
struct DrawnModel {
  TriangleMesh mesh;
  double radius;
  ModelPictures pictures;

  DrawnModel(TriangleMesh read, const std::vector<double>& distances, int threads, Progress* progress)
      : mesh(std::move(read)),
        radius(BoundingSphere::of(mesh).radius),
        pictures(mesh, pictures_from(distances, radius), threads, progress) {}

  static PictureSet pictures_from(const std::vector<double>& distances, double radius) {
    constexpr double kNearest = 1.2;  // radii
    constexpr int kSide = 160;
    PictureSet set{{}, kPixelAtOneMetre, kSide};
    for (const double distance : distances)
      if (distance >= kNearest * radius) set.distances.push_back({distance, sides_from(distance, radius)});
    return set;
  }
  // The model has fewer pixels from afar.
  static int sides_from(double distance, double radius) {
    const double pixels = radius / (kPixelAtOneMetre * distance);
    return pixels > 60.0 ? 4 : pixels > 20.0 ? 8 : 16;
  }

  std::vector<ModelPicture> pixels(const PicturedSurface& surface, double distance, std::size_t count) const {
    const int sides = sides_from(distance, radius);
    return pictures.of(surface, count / size_of(sides), distance);
  }
};

// Moves places of a map to a mosaic of it. Each pixel is put at a random place, and keeps its size in texels.
void move_to_mosaic(std::vector<ModelPicture>& pictures, const glm::dvec2& map_size, const glm::dvec2& mosaic_size) {
  if (map_size == mosaic_size) return;
  const glm::dvec2 ratio = map_size / mosaic_size;
  SplitMix64 random(kMosaic.seed);
  for (ModelPicture& picture : pictures)
    for (ModelPixel& pixel : picture.pixels) {
      const glm::dvec2 before = pixel.middle.place;
      pixel.middle.place = {random.uniform(), random.uniform()};
      for (SurfacePoint& sample : pixel.samples) sample.place = pixel.middle.place + (sample.place - before) * ratio;
      pixel.along_x.place *= ratio;
      pixel.along_y.place *= ratio;
    }
}

}  // namespace

GainSurface surface_of_mosaic(const MapMosaic& mosaic, double tile_metres) {
  const MosaicCuts whole{mosaic.normals.width(), mosaic.normals.height(), {{{0, 0}}}};
  GainSurface made{cut_planes(mosaic.normals, whole), std::nullopt};
  if (mosaic.material) made.material.emplace(cut_planes(*mosaic.material, whole));
  if (made.normals.is_shortened()) divide_by_length(made);
  made.texels_per_metre = std::max(mosaic.map_width, mosaic.map_height) / tile_metres;
  return made;
}

std::vector<ModelSurface> surfaces_of_model(const GltfAsset& asset, const std::string& folder,
                                            const std::vector<double>& distances, int threads, Progress* progress) {
  const GltfPlan plan = plan_gltf(asset, false);
  SourceFitSettings settings;
  settings.folder = folder;
  settings.threads = threads;
  std::map<std::uint64_t, std::shared_ptr<const DrawnModel>> models;  // by set of texture coordinates
  std::vector<ModelSurface> made;
  for (const MaterialPlan& material : plan.materials)
    if (!material.kept.empty() && material.is_bad) made.push_back({material.name, material.kept, std::nullopt});
  for (std::size_t s = 0; s < plan.sources.size(); ++s) {
    std::vector<int> materials;
    for (std::size_t m = 0; m < plan.materials.size(); ++m)
      if (plan.materials[m].kept.empty() && plan.materials[m].source == s) materials.push_back(static_cast<int>(m));
    if (materials.empty()) continue;
    const MaterialPlan& first = plan.materials[size_of(materials.front())];
    ModelSurface& one = made.emplace_back(ModelSurface{first.name, "", std::nullopt});
    const PreparedSource prepared = prepare_source(asset, plan.sources[s], settings);
    one.kept = prepared.kept;
    if (!one.kept.empty()) continue;
    const std::uint64_t set = first.coordinates.set;
    std::shared_ptr<const DrawnModel>& model = models[set];
    if (model == nullptr)
      model = std::make_shared<const DrawnModel>(read_mesh(asset.path, static_cast<int>(set)), distances, threads,
                                                 progress);
    const MappedTriangles triangles(model->mesh, materials, first.coordinates);
    if (triangles.empty()) {
      one.kept = "no triangle shows it";
      continue;
    }
    try {
      const SourcePlanes planes = read_source(asset, prepared, settings, progress);
      const MosaicCuts cuts = cuts_at(triangles, prepared.width, prepared.height);
      one.surface.emplace(GainSurface{cut_planes(planes.normals, cuts), std::nullopt});
      if (planes.material) one.surface->material.emplace(cut_planes(*planes.material, cuts));
    } catch (const Error& error) {
      one.kept = why_kept(asset, error);
      continue;
    }
    const GltfFactors factors = gltf_factors(asset.array("materials").at(size_of(materials.front())));
    one.surface->has_roughness = one.surface->has_metalness = one.surface->material.has_value();
    one.surface->metalness = factors.metalness;
    one.surface->colour = factors.grey;
    one.surface->texels_per_metre = triangles.density(prepared.width, prepared.height);
    one.surface->radius = model->radius;
    const glm::dvec2 map_size(prepared.width, prepared.height),
        mosaic_size(one.surface->normals.width(), one.surface->normals.height());
    const PicturedSurface shown{
        materials, [coordinates = first.coordinates](const glm::dvec2& uv) { return place_in_image(coordinates, uv); }};
    one.surface->model_pixels = [model, shown, map_size, mosaic_size](double distance, std::size_t pixels) {
      std::vector<ModelPicture> seen = model->pixels(shown, distance, pixels);
      move_to_mosaic(seen, map_size, mosaic_size);
      return seen;
    };
    one.roughness = plan.sources[s].roughness_factor;
  }
  return made;
}

}  // namespace multum
