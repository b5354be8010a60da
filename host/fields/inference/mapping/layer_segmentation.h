// SPDX-License-Identifier: Apache-2.0
// Splits ray-traced images into objects (Hakura et al. 2000, section 3.1). Makes one picture per object from a layer's
// picture and every object's coverage, without bleeding across silhouettes. The paper filters the supersampled picture
// under the object's mask and divides by the filtered mask. Here the renderer has already filtered the picture, so a
// mixed pixel is split according to the colours of its objects in nearby pixels.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace multum {

/// Pixels with at least this share count as wholly covered. The limit is below 1, because renderers and OpenGL add up
/// shares from many terms, with rounding errors.
constexpr float kWholeCoverage = 0.999f;

struct SegmentationSettings {
  double sigma = 1.0;       // sigma of the Gaussian in pixels, > 0; its radius is 3 sigma
  double sigma_max = 16.0;  // in pixels; sigma is doubled up to this value until a wholly covered pixel is in reach
  double coverage_whole = static_cast<double>(kWholeCoverage);  // (0.5, 1]
  double coverage_min = 1.0 / 64;  // [0, 1): pixels with less coverage are left out of the object's layer
  double radiance_max = 1.0;       // > 0
  double radiance_min = -1e-3;     // at most 0; lower values are errors, higher negative values are the renderer's
                                   // ringing
  int threads = 0;                 // number of threads; <= 0 means one per core
};

struct SegmentationInput {
  int width = 0, height = 0;
  std::span<const float> rgb;                     // three values per pixel
  std::vector<std::span<const float>> coverages;  // coverage by each object, 0..1 per pixel
};

/// Pixels are counted in each object's layer, so a pixel that two objects share counts twice. Values are counted
/// separately for each channel.
struct SegmentationReport {
  std::size_t not_finite_pixels = 0;  // NaN or infinite in some channel
  std::size_t negative_pixels = 0;    // finite, and below radiance_min in some channel
  std::size_t repaired_pixels = 0;    // invalid pixels replaced by the mean of the object's valid neighbours
  std::size_t dropped_pixels = 0;     // invalid pixels without such neighbours, whose coverage is set to 0
  std::size_t mixed_pixels = 0;       // pixels split between objects
  std::size_t unguided_pixels = 0;    // mixed pixels without a wholly covered pixel of the object in reach
  std::size_t clamped_values = 0;     // negative after splitting, set to 0
  std::size_t clipped_values = 0;     // values above radiance_max, set to radiance_max

  void add(const SegmentationReport& other);
};

struct ObjectLayer {
  std::vector<float> coverage;  // 0 for pixels without a value in the layer
  std::vector<float> rgb;       // 3 per pixel, 0..radiance_max
};

/// Returns one layer per object, in order. The bytes do not depend on the number of threads. `report` may be null.
std::vector<ObjectLayer> segment_layer(const SegmentationInput& input, const SegmentationSettings& settings,
                                       SegmentationReport* report);

/// Returns whether the object is in the layer at all. The object is in the layer if the root mean square over its
/// wholly covered pixels is above 1/4096 of radiance_max, which is the step of 12-bit values. A small highlight is far
/// above this threshold. Artefacts of lossy compression in black areas are far below it.
bool has_radiance(const ObjectLayer& layer, double radiance_max);

}  // namespace multum
