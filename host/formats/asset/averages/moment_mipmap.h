// SPDX-License-Identifier: Apache-2.0
// The contents of a baked file of moments. They are two cheap baselines in one pyramid, which any linear filter mixes
// exactly. For the normals n of each texel, with slopes b = -(n_x, n_y) / n_z, the file stores
//   E[b], E[b b^T]   a Gaussian of slopes (LEAN: Olano and Baker 2010), in the layout of maketx --bumpslopes
//   E[n]             whose length gives the spread in Toksvig's rule (Toksvig 2005)
// If the width of a BRDF is included (BakedHeader::has_roughness), both describe microfacets. The diagonal of E[b b^T]
// is then larger by 1 - c, and n is scaled to c n.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The smallest z that is used for slopes, because slopes grow without bound towards the horizon. Normals with a
/// smaller z use this z, so no slope exceeds 20 (87.1 degrees) and no product exceeds 400. Half floats can store both
/// limits.
constexpr float kSlopeZMin = 0.05f;
constexpr float kSlopeMax = 20.0f;

/// The height that maketx writes for normal maps. Normal maps contain no height.
constexpr float kNoHeight = -1.0f;

/// Moments of slopes, laid out as the channels b0_h to b5_dh2dsdt of maketx --bumpslopes. s grows to the right, and t
/// upwards. A unit normal (+X right, +Y up, +Z out) has the slopes dh/ds = -n_x / n_z and dh/dt = -n_y / n_z.
struct SlopeMoments {
  float height = kNoHeight;
  float s = 0.0f, t = 0.0f;               // E[dh/ds], E[dh/dt]
  float ss = 0.0f, tt = 0.0f, st = 0.0f;  // E[(dh/ds)^2], E[(dh/dt)^2], E[dh/ds dh/dt]
};
static_assert(sizeof(SlopeMoments) == 6 * sizeof(float));

/// A level, or some of its rows, in row-major order from the top of the image.
struct MomentLevel {
  int width = 0;
  int height = 0;
  std::vector<SlopeMoments> slopes;  // index: [y * width + x]
  std::vector<glm::vec3> normals;    // mean vectors, |n| <= 1
  std::vector<glm::vec3> colours;    // mean linear RGB; empty if the map has no colours
  std::vector<float> weights = {};   // mean weights of basis BRDFs; may be empty
};

/// levels[l] is level l of the map. Levels finer than header.first_level have a size, but no texels.
struct MomentMipmap {
  BakedHeader header;
  std::vector<MomentLevel> levels;
};

/// Returns the levels of a map of this size, without texels.
std::vector<MomentLevel> empty_moment_levels(int width, int height);

/// Copies some rows into a level.
MomentLevel rows_of(const MomentLevel& level, int first_row, int row_count);

/// Rounds every value to one that the encoding can store. kFloat rounds nothing. kHalf (docs/reference/file_format.md,
/// "Moments") rounds first moments to nearest, and stores second moments about the rounded first moments. The rounding
/// of the second moment then changes the variance, but the rounding of the mean does not. The error of the variance is
/// at most b^2 / 2048, and a single direction gets variance 0. The mean normal is rounded like a lobe of amplitude 1.
void quantize_moments(MomentLevel& rows, StorageEncoding encoding, int threads);

/// Returns the smallest standard deviation of slopes whose variance the encoding stores with an error of at most a
/// quarter, at a slope of 1. At a slope b, the limit is |b| times this value (test
/// MomentQuantizeTest.KeepsRoughnessDownToTheLeast).
float least_slope_deviation(StorageEncoding encoding);

/// Writes a file atomically, without rounding. Call quantize_moments() first. Throws like write_movmf_mipmap().
void write_moment_mipmap(const std::string& path, const MomentMipmap& mipmap, const BakedWriteOptions& options,
                         Progress* progress = nullptr);

/// Reads a baked file of moments. Throws Error(kInput), which names the file, what was found and what was expected.
/// Decompresses with `threads` threads. 0 means one thread per core.
MomentMipmap read_moment_mipmap(const std::string& path, int threads = 0);

/// Reads only the header. This takes little time for files of any size.
BakedHeader read_moment_header(const std::string& path);

}  // namespace multum
