// SPDX-License-Identifier: Apache-2.0
// Where an image is kept between its file and its use, so that maps larger than memory can be read.
#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "host/image/plane_store.h"

namespace multum {

struct ReadingPlace {
  std::string scratch_folder = ".";
  std::int64_t memory_bytes = std::numeric_limits<std::int64_t>::max();  // what takes more is kept in a scratch file
  int band_rows = 0;  // rows that are read or decoded at once, >= 0; 0: by their width. No result depends on it
};

inline PlaneStore make_plane_store(int width, int height, const ReadingPlace& place) {
  const std::int64_t byte_count = std::int64_t{width} * height * 3 * static_cast<std::int64_t>(sizeof(float));
  return byte_count <= place.memory_bytes ? PlaneStore(width, height) : PlaneStore(width, height, place.scratch_folder);
}

/// Rows a band of decoding: small enough that what every thread holds stays in its cache, enough to be worth a
/// hand-over.
inline int decoding_rows(int width, const ReadingPlace& place) {
  if (place.band_rows > 0) return place.band_rows;
  constexpr int kTexels = 1 << 17, kRowsMin = 4, kRowsMax = 64;
  const int rows = kTexels / width;
  return rows < kRowsMin ? kRowsMin : rows > kRowsMax ? kRowsMax : rows;
}

}  // namespace multum
