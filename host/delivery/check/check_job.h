// SPDX-License-Identifier: Apache-2.0
// Tells whether maps and models gain from multum, before anyone integrates it (docs/how-to/does_my_map_gain.md).
#pragma once

#include <string>
#include <vector>

#include "host/delivery/check/gain_verdict.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_mosaic.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

struct CheckJob {
  std::string input;  // a normal map, a height field, or a model: *.glb or *.gltf
  NormalMapSettings reading;
  bool only_normals = false;  // reject height fields, which statistics cannot tell from grey pictures
  Engine engine = Engine::kThree;
  double tile_metres = 1.0;     // size of the map's longer side on the surface; models have their own size
  double base_roughness = 0.3;  // perceptual roughness of the sentence; used without a roughness map
  bool is_metal = false;        // true for a metal; used without a model
  // True if the material of a mosaic contains maps of roughness and metalness.
  bool has_roughness = false, has_metalness = false;
  int threads = 1;
};

/// Replaces the job's values by the given values of check_parameters().
void apply(const ParameterValues& values, CheckJob& job);

/// Returns the files of a folder that can be normal maps, by their types and names, and the models, sorted by name.
/// Throws Error(kInput) if the folder cannot be read.
std::vector<std::string> files_to_check(const std::string& folder);

/// Returns one verdict for a map, and one per material with a normal map for a model. Throws Error(kInput) for unusable
/// files, Error(kEnvironment) if the device fails, and Cancelled.
std::vector<GainVerdict> check_file(const CheckJob& job, Device& device, Progress* progress);

/// Returns a coarser verdict for a mosaic in a fraction of the time: fewer pixels, and only the roughness of the
/// sentence. `starts` has the starts of the whole map's lobes. It can be null.
GainVerdict quick_verdict(const CheckJob& job, const MapMosaic& mosaic, StartMemory* starts, Device& device,
                          Progress* progress);

}  // namespace multum
