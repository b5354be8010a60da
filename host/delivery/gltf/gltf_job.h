// SPDX-License-Identifier: Apache-2.0
// Converts the file of a glTF or GLB model with normal maps to a GLB file whose normal and metallic-roughness textures
// have fitted mips (docs/reference/gltf.md).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/delivery/gltf/source_forms.h"
#include "host/delivery/gltf/texture_encoding.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/surface_points.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

struct GltfJob {
  std::string input;   // *.glb or *.gltf
  std::string output;  // *.glb
  std::string report;  // JSON file; empty if no report is written
  GltfTextureFormat format = GltfTextureFormat::kAuto;
  bool has_fallback = false;  // also store level 0 of each texture as a plain image
  bool is_anisotropic = false;
  MaterialForm form = MaterialForm::kAuto;  // form of all materials
  Engine engine = Engine::kThree;           // engine whose pictures choose the form
  // If true, adds MULTUM_lobes. With MaterialForm::kAuto, it is added only if lobes reduce the error.
  bool has_lobes = false;
  std::optional<LobeTexels> lobe_texels;  // used only with lobes; if not set, chosen by `format`
  bool is_fast = false;
  MapSurface surface = MapSurface::kTexels;  // surface to which levels 1 and coarser are fitted
  std::optional<ZRange> z_range;             // z range of all normal maps; if not set, found by statistics
  bool two_channel = false;                  // rebuild z of all normal maps
  int uastc_effort = 1;
  std::string encoder;                                    // see UastcSettings::encoder
  std::uint64_t memory_bytes = std::uint64_t{256} << 20;  // memory for buffers and maps; does not change the result
  int threads = 1;
};

struct GltfReport {
  struct Material {
    std::string name;
    std::string kept;  // reason why the material is unchanged; empty if it has new textures
    std::vector<std::string> notes;
    int textures = -1;  // index into `textures`
    std::string form;   // result of the pictures; empty if no pictures were drawn
  };
  /// The new textures, which several materials may share.
  struct Textures {
    int width = 0, height = 0, level_count = 0;
    std::map<std::string, EncodedTexture> storage;  // keys: "normal", "metallic_roughness", "anisotropy", "lobes"

    /// Returns text such as "normals: UASTC 2.1 MB, +0.2 points; ...".
    std::string storage_text() const;
  };
  std::vector<Material> materials;
  std::vector<ChosenForm> forms;  // form of each source; set if pictures chose it
  std::vector<Textures> textures;
  std::vector<std::string> warnings;
  std::uint64_t bytes_before = 0, bytes_after = 0;  // size of the file and of all files to which it refers
  std::string device;
  std::map<std::string, std::uint64_t> launches;        // number of launches per kernel
  std::vector<std::pair<std::string, double>> seconds;  // seconds per stage

  int fitted_count() const;
  std::string to_json(const GltfJob& job) const;
};

/// Replaces the job's values by the given values of gltf_parameters().
void apply(const ParameterValues& values, GltfJob& job);

/// Throws Error and Cancelled. Leaves no partial file. Progress: one unit per fitted texel and one per encoded texel.
GltfReport convert_gltf(const GltfJob& job, Device& device, Progress* progress);

}  // namespace multum
