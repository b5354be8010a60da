// SPDX-License-Identifier: Apache-2.0
// The contents of a baked file of spherical harmonics: the mean of Y_lm(n) over the normals n of each texel. This mean
// is the distribution of normals, cut off above an order (Han et al. 2007, section 5). The mean is linear, so any
// filter mixes texels exactly. If the width of a BRDF is included (BakedHeader::has_roughness), the distribution
// describes microfacets. For a normal of level 0, band l is then scaled by a_l of the vMF with mean cosine
// c(roughness).
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// A level, or some of its rows, in row-major order from the top of the image. Coefficients come in groups of four, in
/// the order of sh_coefficient(). Each group is a texture or an array layer. For an odd order, the last group ends with
/// a 0.
struct ShLevel {
  int width = 0;
  int height = 0;
  std::vector<std::vector<glm::vec4>> parts;  // index: [part][y * width + x]; empty if not stored
  std::vector<glm::vec3> colours;             // mean linear RGB; empty if the map has no colours
  std::vector<float> weights = {};            // mean weights of basis BRDFs; may be empty

  /// Returns coefficient `coefficient` of texel `i`.
  float value(int coefficient, std::size_t i) const {
    return parts[static_cast<std::size_t>(coefficient / 4)][i][coefficient % 4];
  }
};

/// levels[l] is level l of the map. Levels finer than header.first_level have a size, but no texels.
struct ShMipmap {
  BakedHeader header;
  int order = 0;
  std::vector<ShLevel> levels;
};

/// Returns the levels of a map of this size, without texels.
std::vector<ShLevel> empty_sh_levels(int width, int height);

/// Copies some rows into a level.
ShLevel rows_of(const ShLevel& level, int first_row, int row_count);

/// Rounds every value to one that the encoding can store. kHalf rounds to nearest, and kFloat rounds nothing.
void quantize_sh(ShLevel& rows, StorageEncoding encoding, int threads);

/// Returns how much rounding can change the sum of squares of a band, relative to this sum
/// (docs/reference/file_format.md, "Spherical harmonics").
double sh_power_tolerance(StorageEncoding encoding);

/// Writes a file atomically, without rounding. Call quantize_sh() first. Throws like write_movmf_mipmap().
void write_sh_mipmap(const std::string& path, const ShMipmap& mipmap, const BakedWriteOptions& options,
                     Progress* progress = nullptr);

/// Reads a baked file of spherical harmonics. Throws Error(kInput), which names the file, what was found and what was
/// expected. Decompresses with `threads` threads. 0 means one thread per core.
ShMipmap read_sh_mipmap(const std::string& path, int threads = 0);

/// Reads only the header. This takes little time for files of any size. Levels have a size, but no texels.
ShMipmap read_sh_header(const std::string& path);

}  // namespace multum
