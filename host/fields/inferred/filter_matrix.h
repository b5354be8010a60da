// SPDX-License-Identifier: Apache-2.0
// Defines the filter matrix A of texture inference (Hakura et al. 2000, section 3.2, eq. 1), for which picture = A *
// texture. A has one row per pixel that the object covers, and one column per texel of the mip pyramid. The OpenGL
// runtime measures A and writes it to a file. The solver reads this file without OpenGL.
// docs/reference/inferred_textures.md describes the file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/formats/asset/mip_layout.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Describes the measurement. Inferred textures are valid only for this renderer and sampler.
struct FilterMatrixProvenance {
  std::string software;  // such as "multum-view 0.1.0"
  std::string renderer;  // "osmesa: llvmpipe (...), 4.5 (Core Profile) Mesa 22.3.6"
  std::string view;      // names of the camera and of moved objects
  std::string object;
  std::string mesh_hash;    // SHA-256 of positions, coordinates and indices as drawn
  std::string view_matrix;  // SHA-256 of the matrices of every object as drawn
  std::string key;          // set by the requester; equal keys mean equal matrices
};

struct FilterMatrix {
  int width = 0, height = 0;  // size of the picture, pixels
  int supersampling = 1;      // sub-pixels along each side of a pixel, whose rows were averaged
  int texture_width = 1, texture_height = 1;
  WrapMode wrap_s = WrapMode::kClamp, wrap_t = WrapMode::kClamp;
  float anisotropy = 1.0f;
  bool has_mips = true;  // if false, bilinear filtering of level 0 only
  FilterMatrixProvenance provenance;
  /// The number of covered pixels that are left out. In these pixels, the weights of a sub-pixel did not sum to 1
  /// within 1e-4, or did not give the colour that OpenGL drew.
  std::uint64_t rows_rejected = 0;

  // The rows have one entry per covered pixel, by ascending pixel number. The columns of a row are in ascending order.
  std::vector<std::uint32_t> pixels;     // y * width + x, row 0 at the top
  std::vector<float> coverage;           // share of the pixel's sub-pixels, (0, 1]
  std::vector<std::uint32_t> row_begin;  // [rows + 1], indices into the next two lists
  std::vector<std::uint32_t> columns;    // texel number in the order of MipLayout
  std::vector<float> weights;            // each row sums to 1

  std::size_t row_count() const { return pixels.size(); }
  MipLayout layout() const { return MipLayout(texture_width, texture_height); }
};

/// Writes a temporary file and renames it when it is complete. Throws Error(kEnvironment).
void write_filter_matrix(const FilterMatrix& matrix, const std::string& path);

/// Throws Error(kInput), which names the file and its fault. The file can have another format or version, be truncated
/// or damaged, or contain columns beyond the texture or weights that are not finite.
FilterMatrix read_filter_matrix(const std::string& path);

/// Returns only the key. The key is empty if the file does not exist or is not a filter matrix.
std::string filter_matrix_key(const std::string& path);

/// Writes the Matrix Market coordinate format (Boisvert et al. 1996) of type "real general". Indices start at 1, and
/// the provenance is written as comments.
void write_matrix_market(const FilterMatrix& matrix, const std::string& path);

}  // namespace multum
