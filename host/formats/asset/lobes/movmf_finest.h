// SPDX-License-Identifier: Apache-2.0
// Level 0 of a baked map in compact form. Every texel is one direction in one lobe (a = 1, |r| = 1), so it needs only a
// normal, the number of the lobe and a colour. The file stores x and y, and the reader derives z
// (docs/reference/file_format.md, "The finest level"). The structs here hold x, y and z. If the width of a BRDF is
// included, normals are shorter than 1 and planar lobes have a variance, so the file also stores the third value.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Rows of level 0. The rows come from the top, and the texels of a row come from the left.
struct MovmfFinest {
  int width = 0;
  int height = 0;  // rows held here
  // Spherical lobes store unit vectors with z >= 0. Planar lobes store x, y and x^2 + y^2. With `has_roughness`,
  // vectors are shorter, and planar lobes hold x^2 + y^2 + 2 v (host/formats/asset/lobes/gmm_quantize.h).
  std::vector<glm::vec3> normals;
  std::vector<std::uint8_t> lobe;   // the lobe that holds the texel
  std::vector<glm::vec3> colours;   // linear RGB of the texel; empty if the map has no colours
  std::vector<float> weights = {};  // weights of basis BRDFs, the same number per texel as in the map; may be empty
  Representation representation = Representation::kMovmf;
  bool has_roughness = false;  // true if the lengths of normals encode a BRDF's width

  std::size_t weight_count() const { return normals.empty() ? 0 : weights.size() / normals.size(); }
};

/// Returns z of a normal whose x and y are already rounded: sqrt(1 - x^2 - y^2), rounded UP to the encoding's grid
/// (32-bit floats for kFloat). Therefore |(x, y, z)| >= 1, and rounding never adds spread. Readers compute the same
/// value.
float finest_z(float x, float y, StorageEncoding encoding);

/// Returns x^2 + y^2 of rounded x and y, rounded DOWN to the grid. The variance of the Gaussian is then clamped to 0,
/// and filtering texels of one direction adds no variance.
float finest_square(float x, float y, StorageEncoding encoding);

/// The functions that round level 0 for each family of lobes (host/formats/asset/lobes/lobe_family.h). One family has
/// normals with z, and the other has points with x^2 + y^2.
void quantize_unit_vectors(glm::vec3* normals, std::size_t count, StorageEncoding encoding);
void quantize_points(glm::vec3* points, std::size_t count, StorageEncoding encoding);
/// Returns whether the normal is a single direction that one lobe stores. With roughness, this is false, because
/// roughness shortens the vectors and widens planar lobes.
bool is_unit_vector(const glm::vec3& normal, bool has_roughness);
bool is_single_point(const glm::vec3& point, bool has_roughness);

/// Rounds x and y to the nearest value of the grid and derives z. Normals whose length includes the width of a BRDF are
/// rounded in the same way as lobes of amplitude 1. Rounds colours and weights to 16-bit floats unless the encoding is
/// kFloat. Readers of the file get exactly these values.
void quantize_movmf(MovmfFinest& rows, StorageEncoding encoding, int threads);

/// Converts rows of full lobes to rows of level 0. Every texel must be one direction in one lobe, with all other lobes
/// zero (MULTUM_CHECK).
MovmfFinest finest_of(const MovmfLevel& level, int first_row, int row_count,
                      Representation representation = Representation::kMovmf, bool has_roughness = false);

/// Converts rows to full lobes. The lobe of a texel gets (normal, 1) and the colour, and the other lobes get zeros.
MovmfLevel expand(const MovmfFinest& rows, int lobe_count);
/// Expands rows into a level with enough room.
void expand_into(const MovmfFinest& rows, MovmfLevel& level, int first_row, int threads);

}  // namespace multum
