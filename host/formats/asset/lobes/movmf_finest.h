// SPDX-License-Identifier: Apache-2.0
// Level 0 of a baked map, compactly: every texel is one single direction, given whole (a = 1, |r| = 1) to one lobe, so
// that its normal, the number of that lobe and a colour say it all. The file holds x and y alone and the reader derives
// z (docs/reference/file_format.md, "The finest level"); what is here is always whole. With a BRDF's width in, normals
// are shorter than 1, points of the plane scatter, and the file holds the third value too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Rows of level 0, from the top, texels from the left.
struct MovmfFinest {
  int width = 0;
  int height = 0;  // rows that are here
  // Unit, z >= 0; of planar lobes x, y and x^2 + y^2: what lobes of the other levels hold; where `has_roughness`
  // shorter, of planar ones x^2 + y^2 + 2 v (host/formats/asset/lobes/gmm_quantize.h).
  std::vector<glm::vec3> normals;
  std::vector<std::uint8_t> lobe;   // the lobe that the texel is given to
  std::vector<glm::vec3> colours;   // linear RGB of the texel; empty: the map has no colours
  std::vector<float> weights = {};  // of basis BRDFs, as many a texel as the map has; empty: none
  Representation representation = Representation::kMovmf;
  bool has_roughness = false;  // lengths of normals are a BRDF's width

  std::size_t weight_count() const { return normals.empty() ? 0 : weights.size() / normals.size(); }
};

/// z of a normal whose x and y have been rounded: sqrt(1 - x^2 - y^2), rounded UP to the encoding's grid (32-bit floats
/// for kFloat), so that |(x, y, z)| >= 1: rounding never adds spread. Readers do the same.
float finest_z(float x, float y, StorageEncoding encoding);

/// x^2 + y^2 of the same, rounded DOWN to the grid: a Gaussian's variance is clamped to none there, and filtering adds
/// none to texels of one direction.
float finest_square(float x, float y, StorageEncoding encoding);

/// What families of lobes differ in at level 0 (host/formats/asset/lobes/lobe_family.h). Rounding: of normals with z,
/// and of points with x^2 + y^2.
void quantize_unit_vectors(glm::vec3* normals, std::size_t count, StorageEncoding encoding);
void quantize_points(glm::vec3* points, std::size_t count, StorageEncoding encoding);
/// Is it one single direction, as a whole lobe has it? Roughness shortens vectors, and spreads points.
bool is_unit_vector(const glm::vec3& normal, bool has_roughness);
bool is_single_point(const glm::vec3& point, bool has_roughness);

/// Rounds x and y to the nearest value of the grid and derives z; shortened normals as lobes of a = 1; colours and
/// weights to halfs, but for kFloat. What is left is what readers of the file get.
void quantize_movmf(MovmfFinest& rows, StorageEncoding encoding, int threads);

/// Rows of level 0 as full lobes hold them. Every texel must be a single direction whole in one lobe, all other lobes
/// zero (MULTUM_CHECK).
MovmfFinest finest_of(const MovmfLevel& level, int first_row, int row_count,
                      Representation representation = Representation::kMovmf, bool has_roughness = false);

/// The other way round: (normal, 1) and the colour for the lobe that has the texel, zeros for the others.
MovmfLevel expand(const MovmfFinest& rows, int lobe_count);
/// Expands rows into a level that has room for them.
void expand_into(const MovmfFinest& rows, MovmfLevel& level, int first_row, int threads);

}  // namespace multum
