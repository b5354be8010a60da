// SPDX-License-Identifier: Apache-2.0
// The contents of a baked file in memory. They are a mip pyramid whose texels each hold a mixture of von Mises-Fisher
// lobes (Han et al. 2007, section 7). This is the only code that both the bakes (OpenCL) and the runtime (GL) link. A
// lobe is stored as a * (r_x, r_y, r_z, 1). The amplitude is a, and the amplitudes of a texel sum to 1. The mean vector
// of the lobe's normals is r, with |r| <= 1, in tangent space: +X right (u grows), +Y up (towards the image's first
// row), +Z out. All four channels are linear in the normals, so hardware filtering T(.) gives exact first moments: a =
// T(a), r = T(a r) / T(a).
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

/// One level (0 is the finest), with rows from the top of the image to the bottom.
struct MovmfLevel {
  int width = 0;
  int height = 0;
  std::vector<std::vector<glm::vec4>> lobes;    // index: [lobe][y * width + x]; value: (a r_x, a r_y, a r_z, a)
  std::vector<std::vector<glm::vec3>> colours;  // index: [lobe][y * width + x]; value: a * linear RGB; empty if there
                                                // are no colours
  // Index: [lobe][(y * width + x) * weight_count + k]. Value: a * weight k of a basis BRDF. Empty if the map has no
  // weights.
  std::vector<std::vector<float>> weights = {};
};

/// levels[l] is level l of the map. Levels finer than header.first_level have a size, but no texels. Renderers use the
/// normal map for them. header.representation defines the meaning of a lobe (host/formats/asset/lobes/lobe_family.h).
struct MovmfMipmap {
  BakedHeader header;                   // full_header() sets its sizes and its has_colours according to the levels
  std::vector<MovmfLevel> levels = {};  // ROUND_DOWN: level l is max(1, W >> l) by max(1, H >> l), down to 1 x 1

  // The size of the map (level 0).
  int width() const { return levels.empty() ? 0 : levels.front().width; }
  int height() const { return levels.empty() ? 0 : levels.front().height; }
  int lobe_count() const { return levels.empty() ? 0 : static_cast<int>(levels.front().lobes.size()); }
  bool has_colours() const { return !levels.empty() && !levels.front().colours.empty(); }
};

/// Returns the header of a file with these levels.
BakedHeader full_header(const MovmfMipmap& mipmap);
/// Returns a mipmap whose levels have sizes, and `lobe_count` lobes that are empty.
MovmfMipmap empty_movmf_mipmap(const BakedHeader& header, int lobe_count);
inline std::string levels_text(const MovmfMipmap& mipmap) {
  return levels_text(mipmap.header.first_level, static_cast<int>(mipmap.levels.size()));
}

/// Removes the texels of levels finer than `first_level`. The other levels remain unchanged.
void drop_finer_levels(MovmfMipmap& mipmap, int first_level);

/// Copies some rows into a level.
MovmfLevel rows_of(const MovmfLevel& level, int first_row, int row_count);

/// Returns the SHA-256 of a text that consists of the hexadecimal SHA-256 digests of all levels of all parts. Parts
/// come in the order level 0, lobes, colours, and each part begins with its finest level. The digest of a level covers
/// its rows as little-endian 32-bit floats in channel order (docs/reference/file_format.md).
std::string movmf_content_hash(const MovmfMipmap& mipmap, int threads);

/// Writes `mipmap` atomically, without rounding. Call quantize_movmf() first. Each texel of level 0 must be one
/// direction in one lobe, and the file stores its x and y. Throws Error(kEnvironment) if the disk fails, and
/// Error(kUsage) for an unknown compression. Counts no units of progress. The progress callback can cancel after each
/// row of tiles, until the file is renamed to its final name. To write row by row, use MovmfWriter
/// (host/formats/asset/lobes/movmf_writer.h).
void write_movmf_mipmap(const std::string& path, const MovmfMipmap& mipmap, const BakedWriteOptions& options,
                        Progress* progress = nullptr);

/// Reads a baked file of lobes. Throws Error(kInput), which names the file, what was found and what was expected.
/// Decompresses with `threads` threads. 0 means one thread per core.
MovmfMipmap read_movmf_mipmap(const std::string& path, int threads = 0);

/// Reads only the header. This takes little time for files of any size. Levels have sizes, but their lobes are empty.
MovmfMipmap read_movmf_header(const std::string& path);

/// Returns the largest kappa whose spread (1/kappa) a lobe of amplitude 1 stores with an error of at most about a
/// quarter. Rounding makes lobes with a larger kappa even sharper, and they can become a single direction.
float storage_kappa_max(StorageEncoding encoding);

/// Counts the lobes of a level that will lose their spread by rounding because they are sharper than
/// storage_kappa_max(). Single directions do not count, because every encoding keeps them. With kFloat, the count is 0.
struct SharpLobes {
  std::uint64_t count = 0;
  double amplitude = 0.0;  // sum of their amplitudes, in texels
};
SharpLobes count_sharp_lobes(const MovmfLevel& level, StorageEncoding encoding, int threads);

/// Rounds every value to one that `mipmap.encoding` can store (docs/reference/file_format.md, "Rounding"). The
/// amplitudes sum to exactly 1. Rounding never adds spread: a lobe with unit |r| is read as |r| >= 1, which readers
/// clamp to 1. Level 0 is derived from its x and y (host/formats/asset/lobes/movmf_finest.h).
void quantize_movmf(MovmfMipmap& mipmap, int threads);

/// Rounds some or all rows of a level in the same way. The level must not be level 0.
void quantize_movmf(MovmfLevel& rows, StorageEncoding encoding, int threads);

}  // namespace multum
