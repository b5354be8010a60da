// SPDX-License-Identifier: Apache-2.0
// The baked file's contents in memory: a mip pyramid whose texels each hold a mixture of von Mises-Fisher lobes
// (Han et al. 2007, section 7). This is the only code that the bakes (OpenCL) and the runtime (GL) both link.
//
// A lobe is stored as a * (r_x, r_y, r_z, 1): a = amplitude (the lobes of a texel sum to 1), r = the mean vector of the
// lobe's normals, |r| <= 1, tangent space with +X right (u grows), +Y up (towards the image's first row), +Z out.
// All four channels are linear in the normals, so hardware filtering T(.) gives exact first moments: a = T(a),
// r = T(a r) / T(a).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

constexpr int kLobeCountMax = 8;

/// One level, level 0 = finest. Rows from the image's top to its bottom.
struct MovmfLevel {
  int width = 0;
  int height = 0;
  std::vector<std::vector<glm::vec4>> lobes;    // [lobe][y * width + x] = (a r_x, a r_y, a r_z, a)
  std::vector<std::vector<glm::vec3>> colours;  // [lobe][y * width + x] = a * linear RGB; empty: the map has no colours
  // [lobe][(y * width + x) * weight_count + k] = a * weight k of a basis BRDF; empty: the map has no weights
  std::vector<std::vector<float>> weights = {};
};

/// levels[l] is level l of the map. Those finer than header.first_level have their size and no texels: renderers take
/// them from the normal map itself. header.representation says what a lobe is (host/formats/asset/lobes/lobe_family.h).
struct MovmfMipmap {
  BakedHeader header;                   // its sizes and has_colours are those of the levels: full_header()
  std::vector<MovmfLevel> levels = {};  // ROUND_DOWN: level l is max(1, W >> l) by max(1, H >> l), down to 1 x 1

  // Of the map, that is, of level 0.
  int width() const { return levels.empty() ? 0 : levels.front().width; }
  int height() const { return levels.empty() ? 0 : levels.front().height; }
  int lobe_count() const { return levels.empty() ? 0 : static_cast<int>(levels.front().lobes.size()); }
  bool has_colours() const { return !levels.empty() && !levels.front().colours.empty(); }
};

/// The header of a file of these levels.
BakedHeader full_header(const MovmfMipmap& mipmap);
/// A mipmap whose levels have sizes and empty lobes, `lobe_count` of them.
MovmfMipmap empty_movmf_mipmap(const BakedHeader& header, int lobe_count);
inline std::string levels_text(const MovmfMipmap& mipmap) {
  return levels_text(mipmap.header.first_level, static_cast<int>(mipmap.levels.size()));
}

/// Takes the texels of levels finer than `first_level` away; what is left is as it was.
void drop_finer_levels(MovmfMipmap& mipmap, int first_level);

/// Some rows of a level, as a level of their own.
MovmfLevel rows_of(const MovmfLevel& level, int first_row, int row_count);

/// SHA-256 over the SHA-256 digests (hexadecimal text) of each part's levels, the part of level 0 first, then lobes,
/// then colours, finest level first; a level's digest covers its rows as little-endian 32-bit floats in channel order
/// (docs/reference/file_format.md).
std::string movmf_content_hash(const MovmfMipmap& mipmap, int threads);

/// Writes `mipmap` atomically, its values as they are: quantize_movmf() comes first. Level 0 is compacted: each of its
/// texels must be one single direction whole in one lobe, and of that x and y are stored. Throws Error(kEnvironment)
/// when the disk refuses, Error(kUsage) for an unknown compression. Progress: counts no units; cancels at rows of
/// tiles until the file gets its name. MovmfWriter (host/formats/asset/lobes/movmf_writer.h) takes rows instead.
void write_movmf_mipmap(const std::string& path, const MovmfMipmap& mipmap, const BakedWriteOptions& options,
                        Progress* progress = nullptr);

/// Reads a baked file of lobes. Throws Error(kInput) naming the file, what was found and what was expected. `threads`
/// decompress; 0: as many as the machine has.
MovmfMipmap read_movmf_mipmap(const std::string& path, int threads = 0);

/// Reads the header alone: levels have sizes and empty lobes. Cheap for files of any size.
MovmfMipmap read_movmf_header(const std::string& path);

/// Largest kappa whose spread (1/kappa) a lobe of amplitude 1 keeps to within about a quarter; sharper lobes are stored
/// sharper, up to a single direction.
float storage_kappa_max(StorageEncoding encoding);

/// Lobes of a level, before rounding, whose spread is not kept: sharper than storage_kappa_max(), but no single
/// direction, which every encoding keeps. None for kFloat.
struct SharpLobes {
  std::uint64_t count = 0;
  double amplitude = 0.0;  // their sum: texels' worth of normals
};
SharpLobes count_sharp_lobes(const MovmfLevel& level, StorageEncoding encoding, int threads);

/// Rounds every value to what `mipmap.encoding` stores. The rule (docs/reference/file_format.md, "Rounding"):
/// amplitudes sum to 1 exactly, and rounding never adds spread: a lobe of unit |r| decodes to |r| >= 1, which readers
/// clamp to 1. Level 0 is what its x and y make of it (host/formats/asset/lobes/movmf_finest.h).
void quantize_movmf(MovmfMipmap& mipmap, int threads);

/// The same for a level >= 1, or for some of its rows.
void quantize_movmf(MovmfLevel& rows, StorageEncoding encoding, int threads);

}  // namespace multum
