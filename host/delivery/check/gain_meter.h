// SPDX-License-Identifier: Apache-2.0
// Measures how much a normal map gains from multum. Fits the lobes and the export of a mosaic, which is a small part of
// the map, and draws pixels of the model or of a sphere from several distances (host/delivery/forms/material_forms.h).
// The sphere is so large in every picture that its own curvature within a pixel has no effect.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "host/bakes/movmf/start_memory.h"
#include "host/delivery/export/formed_material.h"
#include "host/delivery/forms/material_forms.h"
#include "host/formats/image/plane_store.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// A mosaic of a map (host/formats/image/plane_mosaic.h), and its material.
struct GainSurface {
  PlaneStore normals;
  std::optional<PlaneStore> material;                 // alpha^2, occlusion and metalness
  bool has_roughness = false, has_metalness = false;  // true for planes that come from maps
  double metalness = 0.0;                             // 0..1; multiplies the metalness map
  double colour = 0.5;                                // base colour, grey
  double texels_per_metre = 1024.0;
  double radius = 0.5;  // of the object, in metres
  // If set, returns pixels of the model from a distance in metres, with places on the mosaic. They are as many as asked
  // for, or fewer. There are none from inside the model.
  std::function<std::vector<ModelPicture>(double distance, std::size_t pixels)> model_pixels = {};
};

/// A roughness, and the distances from which it is seen.
struct GainCase {
  double roughness = 0.5;         // perceptual; without effect for a surface with a roughness map
  std::vector<double> distances;  // metres, in ascending order
  std::size_t pixels_per_view = 1200;
};

struct GainSettings {
  Engine engine = Engine::kThree;
  std::vector<GainCase> cases;
  int threads = 1;
  StartMemory* starts = nullptr;  // starts of the whole map's lobes; if null or without them, they are searched
  std::size_t form_pixels = 70;   // pixels per view that choose the form; an export uses kFormPixels
};

enum class GainLight { kSun, kSky };

/// Relative L1 errors of pictures in percent.
struct GainError {
  double distance = 0.0;            // metres
  std::optional<double> roughness;  // not set for a surface with a roughness map
  GainLight light = GainLight::kSun;
  double plain = 0.0;     // the map's own mips, which average
  double exported = 0.0;  // textures of `multum export --form auto`
  double lobes = 0.0;     // lobes, drawn with 4 evaluations per pixel
  double noise = 0.0;     // error of the reference
};

/// The size of a pixel at distance 1, for a picture of 1080 rows with a field of view of 45 degrees.
extern const double kPixelAtOneMetre;

/// Returns the errors by case, distance and light, in this order. Distances from which the object is smaller than a
/// few pixels are omitted. Throws Error(kEnvironment) if the device fails, and Cancelled.
std::vector<GainError> measure_gain(Device& device, const GainSurface& surface, const GainSettings& settings,
                                    Progress* progress);

}  // namespace multum
