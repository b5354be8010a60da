// SPDX-License-Identifier: Apache-2.0
// The baked file's contents where it holds spherical harmonics: of every texel's normals n the mean of Y_lm(n), which
// is the distribution of normals itself, cut off above an order (Han et al. 2007, section 5). Linear: any filter mixes
// it exactly. With a BRDF's width in (BakedHeader::has_roughness) it is that of facets: a finest normal's band l is
// times a_l of the vMF of its mean cosine c(roughness).
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// A level, or some of its rows. Row-major, from the image's top. Coefficients four by four, in the order of
/// sh_coefficient(): a texture each, or a layer of an array. Behind the last of an odd order there is a 0.
struct ShLevel {
  int width = 0;
  int height = 0;
  std::vector<std::vector<glm::vec4>> parts;  // [part][y * width + x]; empty: not stored
  std::vector<glm::vec3> colours;             // mean linear RGB; empty: the map has no colours
  std::vector<float> weights = {};            // mean weights of basis BRDFs, as many a texel; empty: none

  /// Coefficient number `coefficient` of texel `i`.
  float value(int coefficient, std::size_t i) const {
    return parts[static_cast<std::size_t>(coefficient / 4)][i][coefficient % 4];
  }
};

/// levels[l] is level l of the map. Those finer than header.first_level have their size and no texels.
struct ShMipmap {
  BakedHeader header;
  int order = 0;
  std::vector<ShLevel> levels;
};

/// Levels of a map of that size: sizes without texels.
std::vector<ShLevel> empty_sh_levels(int width, int height);

/// Some rows of a level, as a level of their own.
ShLevel rows_of(const ShLevel& level, int first_row, int row_count);

/// Rounds every value to what the encoding stores. kHalf: to nearest. kFloat: nothing is rounded.
void quantize_sh(ShLevel& rows, StorageEncoding encoding, int threads);

/// Largest change that rounding makes to a band's sum of squares, as a part of it (docs/reference/file_format.md,
/// "Spherical harmonics").
double sh_power_tolerance(StorageEncoding encoding);

/// Writes atomically, values as they are: quantize_sh() comes first. Throws as write_movmf_mipmap() does.
void write_sh_mipmap(const std::string& path, const ShMipmap& mipmap, const BakedWriteOptions& options,
                     Progress* progress = nullptr);

/// Reads a baked file of spherical harmonics. Throws Error(kInput) naming the file, what was found and what was
/// expected. `threads` decompress; 0: as many as the machine has.
ShMipmap read_sh_mipmap(const std::string& path, int threads = 0);

/// Reads the header alone: levels have sizes and no texels. Cheap for files of any size.
ShMipmap read_sh_header(const std::string& path);

}  // namespace multum
