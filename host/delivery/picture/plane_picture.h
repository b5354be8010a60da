// SPDX-License-Identifier: Apache-2.0
// Draws a plane that is covered with a baked map of lobes, on an OpenCL device (kernels/plane_picture.cl). The formulas
// are those of the GL runtime. Programs without OpenGL, such as notebooks, use these pictures.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/formats/brdf/brdf.h"
#include "host/formats/brdf/vmf_terms.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The camera and the light. One tile of the map covers 0 <= x <= 1 and 0 <= y <= 1 of the plane z = 0, and the first
/// row of the map is at y = 1. Tiles repeat, or end at the border, as the map's wrap modes state.
struct PlaneView {
  glm::dvec3 eye{0.5, -0.7, 0.7}, target{0.5, 0.5, 0.0};
  double fov = 40.0;                // vertical angle of view in degrees, above 0 and below 180
  glm::dvec3 light{0.0, 0.0, 1.0};  // unit vector to a distant light, whose irradiance is 1 on a surface that faces it
  int width = 256, height = 256;    // pixels
  int taps = 4;                     // largest number of lookups per pixel, along the longer side of its footprint
};

/// The texels of a map, level by level.
class PlaneTexels {
 public:
  virtual ~PlaneTexels() = default;
  virtual const BakedHeader& header() const = 0;
  virtual int lobe_count() const = 0;
  /// Return the values of a stored level, [lobe][row][column][4] and [lobe][row][column][3]. Colours are multiplied by
  /// the lobe's amplitude. They are needed only if the header has colours. The values must stay valid.
  virtual const std::vector<float>& lobes(int level) const = 0;
  virtual const std::vector<float>& colours(int level) const = 0;
};

/// A BRDF and the sum of vMFs that replaces its facets. The sum is empty if there is no highlight.
struct PlaneBrdf {
  const Brdf& brdf;
  const std::vector<VmfTerm>& terms;
  double exponent;  // Blinn-Phong exponent of about the same width
};

/// Draws the picture and returns linear RGB and the coverage (0 or 1), [row][column][4], with row 0 at the top. Reads
/// only the levels that the picture needs. If the map was baked with roughness, its widths replace the width and the
/// visibility term of the BRDF. Throws Error(kUsage) for settings out of range, Error(kEnvironment), and Cancelled.
std::vector<float> draw_plane(Device& device, const PlaneTexels& texels, const PlaneBrdf& brdf, const PlaneView& view,
                              Progress* progress);

}  // namespace multum
