// SPDX-License-Identifier: Apache-2.0
// Reads albedo maps as linear RGB, so that averages over texels are averages of light.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// Linear RGB in planes of width * height floats.
struct ColourMap {
  int width = 0;
  int height = 0;
  std::vector<float> r, g, b;
  std::string format;              // "png uint8, 3 channels, sRGB"
  std::int64_t clamped_count = 0;  // texels with a negative or non-finite value, read as 0
  std::vector<std::string> notes;  // RawImageInfo::notes
};

/// Gives access to the map's planes by rows; the map must outlive the result.
inline PlaneStore planes_of(const ColourMap& map) {
  return {map.width, map.height, {map.r.data(), map.g.data(), map.b.data()}};
}

/// Reads an albedo. Integers of 8 and 16 bits are sRGB unless the file states another colour space, and floats are
/// linear. Grey becomes RGB, and alpha is ignored. Throws Error(kInput), also if the size is not `width` x `height`.
ColourMap read_albedo_map(const std::string& path, int width, int height, int threads);

struct ColourRows {
  PlaneStore planes;
  int channel_count = 0;                // channels of the file, 1 or 3; if it is 1, all planes are equal
  std::string format;                   // "png uint8, 3 channels, sRGB"
  std::int64_t clamped_count = 0;       // as in ColourMap
  float largest = 0.0f;                 // largest of all values
  std::vector<std::string> notes = {};  // RawImageInfo::notes
};

/// Reads an albedo into a store that `spill` makes. Only a few bands of rows of the file are in memory. Throws
/// Error(kEnvironment) if scratch files cannot be written.
ColourRows read_albedo_rows(const std::string& path, int width, int height, const SpillPolicy& spill, int threads);

/// Reads an image of any size. Throws like read_albedo_rows().
ColourRows read_colour_rows(const std::string& path, ColourEncoding encoding, const SpillPolicy& spill, int threads,
                            Progress* progress);

// The sRGB transfer functions (IEC 61966-2-1), on 0..1.
double linear_from_srgb(double encoded);
double srgb_from_linear(double linear);

}  // namespace multum
