// SPDX-License-Identifier: Apache-2.0
// The baked file's contents where it holds moments: the cheap baselines, in one pyramid that any linear filter mixes
// exactly. Of every texel's normals n, with slopes b = -(n_x, n_y) / n_z:
//   E[b], E[b b^T]   a Gaussian of slopes (LEAN: Olano and Baker 2010), as maketx --bumpslopes lays them out
//   E[n]             whose length is the spread of Toksvig's rule (Toksvig 2005)
// With a BRDF's width in (BakedHeader::has_roughness) both are of the microfacets: E[b b^T] has 1 - c more on its
// diagonal, and n is c n.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Slopes grow without bound towards the horizon: those of normals with a smaller z are taken at this z, so that no
/// slope is steeper than 20 (87.1 degrees) and no product larger than 400. Half floats hold both.
constexpr float kSlopeZMin = 0.05f;
constexpr float kSlopeMax = 20.0f;

/// The height that maketx writes for normal maps, which have none.
constexpr float kNoHeight = -1.0f;

/// Moments of slopes, laid out as the channels b0_h to b5_dh2dsdt of maketx --bumpslopes. s grows to the right, t up:
/// of a unit normal (+X right, +Y up, +Z out) the slopes dh/ds = -n_x / n_z, dh/dt = -n_y / n_z.
struct SlopeMoments {
  float height = kNoHeight;
  float s = 0.0f, t = 0.0f;               // E[dh/ds], E[dh/dt]
  float ss = 0.0f, tt = 0.0f, st = 0.0f;  // E[(dh/ds)^2], E[(dh/dt)^2], E[dh/ds dh/dt]
};
static_assert(sizeof(SlopeMoments) == 6 * sizeof(float));

/// A level, or some of its rows. Row-major, from the image's top.
struct MomentLevel {
  int width = 0;
  int height = 0;
  std::vector<SlopeMoments> slopes;  // [y * width + x]
  std::vector<glm::vec3> normals;    // mean vector, |n| <= 1
  std::vector<glm::vec3> colours;    // mean linear RGB; empty: the map has no colours
  std::vector<float> weights = {};   // mean weights of basis BRDFs, as many a texel as the map has; empty: none
};

/// levels[l] is level l of the map. Those finer than header.first_level have their size and no texels.
struct MomentMipmap {
  BakedHeader header;
  std::vector<MomentLevel> levels;
};

/// Levels of a map of that size: sizes without texels.
std::vector<MomentLevel> empty_moment_levels(int width, int height);

/// Some rows of a level, as a level of their own.
MomentLevel rows_of(const MomentLevel& level, int first_row, int row_count);

/// Rounds every value to what the encoding stores. kHalf (docs/reference/file_format.md, "Moments"): first moments to
/// nearest; second moments are those about the rounded first ones, so that the variance loses one rounding of the
/// square and not two of the mean: it is off by at most b^2 / 2048, and a single direction (no variance) gets none. The
/// mean normal as a lobe of a = 1. kFloat: nothing is rounded.
void quantize_moments(MomentLevel& rows, StorageEncoding encoding, int threads);

/// The least standard deviation of slopes that the encoding keeps to within a quarter of its variance, at a slope of 1;
/// at a slope b it is |b| times that (test MomentQuantizeTest.KeepsRoughnessDownToTheLeast).
float least_slope_deviation(StorageEncoding encoding);

/// Writes atomically, values as they are: quantize_moments() comes first. Throws as write_movmf_mipmap() does.
void write_moment_mipmap(const std::string& path, const MomentMipmap& mipmap, const BakedWriteOptions& options,
                         Progress* progress = nullptr);

/// Reads a baked file of moments. Throws Error(kInput) naming the file, what was found and what was expected.
/// `threads` decompress; 0: as many as the machine has.
MomentMipmap read_moment_mipmap(const std::string& path, int threads = 0);

/// Reads the header alone. Cheap for files of any size.
BakedHeader read_moment_header(const std::string& path);

}  // namespace multum
