// SPDX-License-Identifier: Apache-2.0
// Reads normal maps and height fields. Statistics reveal the meaning of the values in the file. The meaning is printed,
// and settings can override it. A file that holds neither normals nor heights is rejected, and the message gives the
// reason. If a single property is unclear, most often green, the usual value is used with a warning
// (docs/reference/input_maps.md lists the rules).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/colour_map.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/wrap_mode.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

class TileSet;  // defined in host/formats/image/normals/tile_set.h

/// The origin of a wrap mode: the default, a setting, or the map itself (periodic if it tiles, otherwise clamp).
enum class WrapOrigin { kDefault, kSaid, kFound };

struct NormalMapSettings {
  BumpFormat bump_format = BumpFormat::kAuto;
  std::optional<GreenAxis> green = std::nullopt;   // if unset, statistics decide; up if they cannot
  std::optional<bool> is_signed = std::nullopt;    // if unset, statistics decide; true if values are vectors, false if
                                                   // they are 0..1
  std::optional<bool> two_channel = std::nullopt;  // if unset, statistics decide; true for z = sqrt(1 - x^2 - y^2)
  std::optional<ZRange> z_range = std::nullopt;    // if unset, statistics decide; for unsigned files that store z
  float height_scale = 1.0f;                       // height, in texels, for a value difference of 1; finite and not 0
  bool dequantize = false;                         // true to use the smoothest surface that fits heights with few bits
  float normal_scale = 1.0f;              // scale of x and y of a normal map, as in glTF's normal textures; finite
  WrapMode wrap_s = WrapMode::kPeriodic;  // wrap mode for height differences at the border
  WrapMode wrap_t = WrapMode::kPeriodic;
  WrapOrigin wrap_s_origin = WrapOrigin::kDefault;  // if kFound, wrap_s has no meaning
  WrapOrigin wrap_t_origin = WrapOrigin::kDefault;
  bool refuse_doubts = false;  // true to reject grey, and a blue that is not z, even if bump_format is kNormal
  bool check_nan = false;      // true to reject the file at the first NaN or Inf; the message gives its position
  FixNan fix_nan = FixNan::kBox3;
  float repair_share_max = 0.01f;  // largest share of repaired texels, 0..1; the file is rejected if more texels need
                                   // repair
  std::int64_t texel_count_max = std::int64_t{1} << 30;
  // A tile of a set that is read as one surface. `tiles` is null for a single map. Jobs for tiles of the same set share
  // `tiles`.
  std::shared_ptr<TileSet> tiles = nullptr;
  std::string tile = "";
};

/// Shares of texels that were never written. Above the first limit, a warning is printed. Above the second limit, the
/// file is rejected, unless BumpFormat::kNormal declares it a normal map. Up to the first limit, NaN texels and signed
/// texels of 0 count as single faults, which are repaired.
constexpr double kUnusedShareNoted = 0.01;
constexpr double kUnusedShareMax = 0.5;

/// Findings and repairs; the bake prints them and writes them into its report.
struct NormalMapReport {
  std::string format;    // "png uint8, 3 channels"
  std::string encoding;  // "normal map, unsigned, green up (OpenGL)", "height field"
  bool is_height_field = false;
  std::string encoding_reason;              // statistics that justify the encoding, in one line
  std::int64_t unused_texels = 0;           // texels that were never written (docs/reference/input_maps.md) or have no
                                            // data
  std::int64_t nonfinite_repaired = 0;      // repaired by NormalMapSettings::fix_nan
  std::int64_t zero_length_repaired = 0;    // replaced by the mean of the 3 x 3 neighbours, or by a flat normal
  std::int64_t below_horizon_repaired = 0;  // lifted to kHorizonZ (host/formats/image/normals/normal_decode.h)
  WrapMode wrap_s = WrapMode::kPeriodic;    // taken from the settings, or found in the map
  WrapMode wrap_t = WrapMode::kPeriodic;
  std::string tiles;                  // record of data from other tiles of a set (tile_source_hash()); may be empty
  std::vector<std::string> warnings;  // doubtful choices, one per line, with the option that settles each
};

/// Unit normals in tangent space: +X right, +Y up (towards row 0), +Z out. The planes have width * height floats, with
/// row 0 at the top.
struct NormalMap {
  int width = 0;
  int height = 0;
  std::vector<float> x, y, z;
  NormalMapReport report;
  bool is_shortened = false;  // true if their lengths include roughness, like PlaneStore::is_shortened()
};

/// Gives access to the map's planes by rows; the map must outlive the result.
inline PlaneStore planes_of(const NormalMap& map) {
  PlaneStore planes(map.width, map.height, {map.x.data(), map.y.data(), map.z.data()});
  planes.set_shortened(map.is_shortened);
  return planes;
}

/// A map that is accessed by rows, and may be larger than memory.
struct NormalMapRows {
  PlaneStore normals;
  NormalMapReport report;
};

/// Reads PNG, JPEG, WebP, TIFF or OpenEXR. Throws Error(kInput), which names the file, what was found and what was
/// expected. Throws Error(kUsage) for settings outside their ranges. Progress names its stage, counts no units, and can
/// cancel between bands. The result does not depend on `threads` (<= 0 means one per core).
NormalMap read_normal_map(const std::string& path, const NormalMapSettings& settings, int threads, Progress* progress);

/// Reads the map into a store that `spill` makes. Only a few bands of rows of file and map are in memory, except for
/// formats that OpenImageIO decodes as a whole (docs/reference/input_maps.md). Throws Error(kEnvironment) if scratch
/// files cannot be written.
NormalMapRows read_normal_map_rows(const std::string& path, const NormalMapSettings& settings, const SpillPolicy& spill,
                                   int threads, Progress* progress);

}  // namespace multum
