// SPDX-License-Identifier: Apache-2.0
// Samples some pixels of small pictures of a model. For each pixel, finds the surface point at the middle, which a
// renderer shades, and the surface points at many samples, which the reference shades. A visibility buffer holds the
// nearest triangle at every sample (Burns and Hunt 2013). The pictures show the model from several sides and distances,
// at the size that a viewer sees.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// A place on the surface, or the difference of two places, which is the change of the interpolated values.
struct SurfacePoint {
  glm::dvec3 position{0.0}, normal{0.0, 0.0, 1.0}, tangent{1.0, 0.0, 0.0}, bitangent{0.0, 1.0, 0.0};
  glm::dvec2 place{0.0};  // place in the image, 0 to 1, from its top left corner

  SurfacePoint operator+(const SurfacePoint& other) const {
    return {position + other.position, normal + other.normal, tangent + other.tangent, bitangent + other.bitangent,
            place + other.place};
  }
  SurfacePoint operator-(const SurfacePoint& other) const { return *this + other * -1.0; }
  SurfacePoint operator*(double factor) const {
    return {factor * position, factor * normal, factor * tangent, factor * bitangent, factor * place};
  }
};

struct ModelPixel {
  SurfacePoint middle;                // place on the triangle under the pixel's middle
  SurfacePoint along_x, along_y;      // change from pixel to pixel, on the plane of the same triangle
  std::vector<SurfacePoint> samples;  // empty if flat_side is above 0
  int flat_side = 0;                  // if above 0, the samples are a grid with this side, interpolated from the middle

  std::size_t sample_count() const;
  SurfacePoint sample(std::size_t i) const;
  /// Returns the place of a sample of a grid with this side, in pixels from the middle.
  static glm::dvec2 grid_place(int i, int side);
};

struct ModelPicture {
  double distance = 0.0;   // distance from the eye to the model's middle, in model units
  std::string shape = {};  // shape of host/delivery/forms/simple_views.h; empty for a model
  glm::dvec3 eye{0.0};
  glm::dmat3 to_view{1.0};  // converts directions to view space
  std::vector<ModelPixel> pixels;
};

/// The triangles of a surface, and the positions of their texels.
struct PicturedSurface {
  std::vector<int> materials;                                // indices in the file
  std::function<glm::dvec2(const glm::dvec2&)> place_of_uv;  // converts the mesh's coordinates, whose v grows upwards
};

/// A distance from the model's middle in model units, and the number of sides from which it is seen.
struct PicturedDistance {
  double distance;
  int side_count;
};

struct PictureSet {
  std::vector<PicturedDistance> distances;  // from outside the bounding sphere
  double pixel = 0.0;                       // width of a pixel at distance 1
  int side = 0;                             // the most pixels per side; a larger model is cut off there

  /// Pictures in which the model fills 240 x 240 pixels or less, down to a few pixels.
  static PictureSet of_all_sizes(double radius);
};

/// A sphere around all vertices of a mesh. The radius is 0 for an empty or infinite mesh.
struct BoundingSphere {
  glm::dvec3 middle{0.0};
  double radius = 0.0;

  static BoundingSphere of(const TriangleMesh& mesh);
};

/// Pictures of a whole model, drawn once for all its surfaces.
class ModelPictures {
 public:
  /// The progress callback can cancel, but no progress units are advanced. `mesh` must outlive this object.
  ModelPictures(const TriangleMesh& mesh, const PictureSet& set, int threads, Progress* progress);
  ~ModelPictures();
  ModelPictures(const ModelPictures&) = delete;
  ModelPictures& operator=(const ModelPictures&) = delete;

  /// For every picture, returns pixels of which the surface covers at least half. Pictures without such pixels are
  /// omitted. At most `pixel_max` pixels per picture are chosen, spread evenly.
  std::vector<ModelPicture> of(const PicturedSurface& surface, std::size_t pixel_max) const;
  /// Does the same for the pictures from one distance.
  std::vector<ModelPicture> of(const PicturedSurface& surface, std::size_t pixel_max, double distance) const;

 private:
  struct View;
  std::optional<ModelPicture> picture_of(const View& view, const PicturedSurface& surface, std::size_t pixel_max) const;
  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> material_of_;  // by triangle
  std::vector<View> views_;
};

/// Makes a sphere of radius 1 whose texture repeats twice around it, for materials that no model uses.
TriangleMesh textured_sphere();

}  // namespace multum
