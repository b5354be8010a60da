// SPDX-License-Identifier: Apache-2.0
// Reading of normal maps and height fields: what the file's numbers mean is found from their statistics, printed, and
// can be overridden. What is neither normals nor heights is refused with the reason; where a single property cannot be
// told, green above all, the usual one is taken with a warning (docs/reference/input_maps.md has the rules).
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

class TileSet;  // host/formats/image/normals/tile_set.h

/// Origin of a wrap mode: nobody said one, somebody did, or it is to be found: periodic where the map tiles, else
/// clamp.
enum class WrapOrigin { kDefault, kSaid, kFound };

struct NormalMapSettings {
  BumpFormat bump_format = BumpFormat::kAuto;
  std::optional<GreenAxis> green = std::nullopt;   // unset: from statistics, up when they cannot tell
  std::optional<bool> is_signed = std::nullopt;    // unset: from statistics; true: values are the vector, false: 0..1
  std::optional<bool> two_channel = std::nullopt;  // unset: from statistics; true: z = sqrt(1 - x^2 - y^2)
  std::optional<ZRange> z_range = std::nullopt;    // unset: from statistics; of unsigned files that store z
  float height_scale = 1.0f;  // height difference in texels that a value difference of 1 stands for; finite, != 0
  bool dequantize = false;    // heights of few bits: take the smoothest that round to them
  float normal_scale = 1.0f;  // x and y of a normal map times this, as glTF scales normal textures; finite
  WrapMode wrap_s = WrapMode::kPeriodic;  // used by height differences at the border
  WrapMode wrap_t = WrapMode::kPeriodic;
  WrapOrigin wrap_s_origin = WrapOrigin::kDefault;  // kFound: wrap_s says nothing
  WrapOrigin wrap_t_origin = WrapOrigin::kDefault;
  bool refuse_doubts = false;  // grey, or a blue that is no z, even where bump_format says that it is a normal map
  bool check_nan = false;      // refuse the first NaN or Inf, with its position
  FixNan fix_nan = FixNan::kBox3;
  float repair_share_max = 0.01f;  // of all texels, 0..1: more repairs than this refuse the file
  std::int64_t texel_count_max = std::int64_t{1} << 30;
  // A tile of a set that is read as one surface; null: a map by itself. Jobs of one set share it.
  std::shared_ptr<TileSet> tiles = nullptr;
  std::string tile = "";
};

/// Texels that were never written, as a share of all: more than the first is warned of, more than the second is refused
/// unless BumpFormat::kNormal says that the file is a normal map. Up to the first, texels of NaN and signed texels of 0
/// are single faults, which are repaired.
constexpr double kUnusedShareNoted = 0.01;
constexpr double kUnusedShareMax = 0.5;

/// Findings and repairs; printed by the bake and written into its report.
struct NormalMapReport {
  std::string format;                       // "png uint8, 3 channels"
  std::string encoding;                     // "normal map, unsigned, green up (OpenGL)", "height field"
  std::string encoding_reason;              // the statistics behind it, one line
  std::int64_t unused_texels = 0;           // never written (docs/reference/input_maps.md), or no data: flat, no repair
  std::int64_t nonfinite_repaired = 0;      // by NormalMapSettings::fix_nan
  std::int64_t zero_length_repaired = 0;    // mean of the 3 x 3 neighbours, else flat
  std::int64_t below_horizon_repaired = 0;  // lifted to kHorizonZ (host/formats/image/normals/normal_decode.h)
  WrapMode wrap_s = WrapMode::kPeriodic;    // as the settings have it, or as it was found
  WrapMode wrap_t = WrapMode::kPeriodic;
  std::string tiles;                  // what was taken from other tiles of a set (tile_source_hash()); empty: nothing
  std::vector<std::string> warnings;  // what was taken in doubt, and the option that settles it; a line each
};

/// Unit normals in tangent space: +X right, +Y up (towards row 0), +Z out; planes of width * height floats, row 0 on
/// top.
struct NormalMap {
  int width = 0;
  int height = 0;
  std::vector<float> x, y, z;
  NormalMapReport report;
  bool is_shortened = false;  // by roughness, as PlaneStore::is_shortened() has it
};

/// The map's planes, to be read by rows; the map must outlive it.
inline PlaneStore planes_of(const NormalMap& map) {
  PlaneStore planes(map.width, map.height, {map.x.data(), map.y.data(), map.z.data()});
  planes.set_shortened(map.is_shortened);
  return planes;
}

/// A map by rows, which may be larger than memory.
struct NormalMapRows {
  PlaneStore normals;
  NormalMapReport report;
};

/// Reads PNG, JPEG, WebP, TIFF or OpenEXR. Throws Error(kInput) naming the file, what was found and what was expected;
/// Error(kUsage) for settings outside their ranges. Progress: names its stage and cancels at bands of rows, counts no
/// units. The result does not depend on `threads` (<= 0: as many as the machine has).
NormalMap read_normal_map(const std::string& path, const NormalMapSettings& settings, int threads, Progress* progress);

/// The same numbers, kept as `place` says. Of the file and of the map a few bands of rows are in memory, but for
/// formats that OpenImageIO decodes whole (docs/reference/input_maps.md). Throws Error(kEnvironment) when scratch files
/// cannot be written.
NormalMapRows read_normal_map_rows(const std::string& path, const NormalMapSettings& settings, const SpillPolicy& spill,
                                   int threads, Progress* progress);

}  // namespace multum
