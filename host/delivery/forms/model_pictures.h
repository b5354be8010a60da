// SPDX-License-Identifier: Apache-2.0
// Small pictures of a model, some pixels of each: what lies under their middles, as a renderer shades it, and under
// many samples, as it ought to be shaded. Triangles are drawn into a buffer of the nearest one at every sample (a
// visibility buffer; Burns and Hunt 2013), from several sides and distances, as large as a person sees the model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// A place on the surface, and its differences: what an interpolated value changes by.
struct SurfacePoint {
  glm::dvec3 position{0.0}, normal{0.0, 0.0, 1.0}, tangent{1.0, 0.0, 0.0}, bitangent{0.0, 1.0, 0.0};
  glm::dvec2 place{0.0};  // in the image, 0 to 1 across it, from its top left corner

  SurfacePoint operator+(const SurfacePoint& other) const;
  SurfacePoint operator-(const SurfacePoint& other) const;
  SurfacePoint operator*(double factor) const;
};

struct ModelPixel {
  SurfacePoint middle;            // of the triangle under the pixel's middle
  SurfacePoint along_x, along_y;  // what it changes by from pixel to pixel, on that triangle's plane
  std::vector<SurfacePoint> samples;
};

struct ModelPicture {
  double distance = 0.0;   // of the eye from the model's middle, in its units
  std::string shape = {};  // host/delivery/forms/simple_views.h; empty: a model
  glm::dvec3 eye{0.0};
  glm::dmat3 to_view{1.0};  // turns directions to the space of the view
  std::vector<ModelPixel> pixels;
};

/// Which triangles are asked for, and where their texels are.
struct PicturedSurface {
  std::vector<int> materials;                                // by index in the file
  std::function<glm::dvec2(const glm::dvec2&)> place_of_uv;  // from the mesh's own, whose v grows upwards
};

/// What is seen of a whole model, drawn once for all its surfaces.
class ModelPictures {
 public:
  /// Progress: cancels. `mesh` must outlive it.
  ModelPictures(const TriangleMesh& mesh, int threads, Progress* progress);
  ~ModelPictures();
  ModelPictures(const ModelPictures&) = delete;
  ModelPictures& operator=(const ModelPictures&) = delete;

  /// Pixels that the surface covers by at least half, in every picture where there are some: at most `pixel_max` each,
  /// evenly spread over them.
  std::vector<ModelPicture> of(const PicturedSurface& surface, std::size_t pixel_max) const;

 private:
  struct View;
  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> material_of_;  // by triangle
  std::vector<View> views_;
};

/// A sphere of radius 1 whose texture goes round it twice: for materials that are on no model.
TriangleMesh textured_sphere();

}  // namespace multum
