// SPDX-License-Identifier: Apache-2.0
// Which parts a baked file has, in order, with which channels and levels: what writer, reader and checksum agree on
// (docs/FORMAT.md, "Parts and channels"). For host/asset alone.
#pragma once

#include <ImfFrameBuffer.h>
#include <ImfPixelType.h>

#include <string>
#include <vector>

#include "host/asset/movmf_finest.h"
#include "host/asset/movmf_mipmap.h"

namespace multum {

enum class MovmfPartKind { kFinest, kLobe, kColour };

struct MovmfChannel {
  std::string name;
  Imf::PixelType type;
};

struct MovmfPart {
  MovmfPartKind kind;
  int lobe;  // of kLobe and kColour
  std::string name;
  std::vector<MovmfChannel> channels;  // as values lie in memory, interleaved, and as they are hashed
  int first_level;
  int level_count;

  bool has_level(int level) const { return level >= first_level && level < first_level + level_count; }
  /// The first value of a level's rows, for kLobe and kColour.
  const float* values(const MovmfLevel& rows) const;
  float* values(MovmfLevel& rows) const;
};

/// Of a mipmap with or without texels.
std::vector<MovmfPart> movmf_parts(const MovmfMipmap& header);

/// Texels of the part "finest" as values lie there, interleaved: R, G, B where there are colours, lobe, x, y.
void interleave(const MovmfFinest& rows, std::size_t first_texel, std::size_t count, float* values);

/// OpenEXR's threads are one pool for all files of the process: it only grows.
void use_exr_threads(int threads);

/// One channel of rows as OpenEXR takes or gives them: `first` is its value at the left end of `first_row`.
Imf::Slice row_slice(Imf::PixelType type, const void* first, std::size_t texel_stride, int width, int first_row,
                     int row_count);

inline std::size_t texel_count(int width, int rows) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(rows);
}

}  // namespace multum
