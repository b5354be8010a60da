// SPDX-License-Identifier: Apache-2.0
// Computes statistics of the values of an image, read as vectors, for host/formats/image/normals/encoding_detection.
#pragma once

#include <memory>

#include "host/formats/image/normals/normal_decode.h"
#include "host/formats/image/raw_image.h"

namespace multum {

/// Statistics of a normal map for one encoding of its numbers. Shares refer to the texels that hold a vector.
struct VectorStatistics {
  double texel_count = 0.0;     // number of texels that are finite and written
  double unit_share_5 = 0.0;    // share with | |v| - 1 | <= 0.05
  double unit_share_10 = 0.0;   // share with | |v| - 1 | <= 0.10
  double unit_share_20 = 0.0;   // share with | |v| - 1 | <= 0.20
  double below_share = 0.0;     // share with z < 0
  double beyond_share = 0.0;    // share with x^2 + y^2 > 1.04, which are not unit vectors even with 8-bit rounding
  double tilted_share = 0.0;    // share with |x| or |y| > 0.02
  double negative_share = 0.0;  // share with x or y < -0.02
  double mean_x = 0.0, mean_y = 0.0, mean_z = 0.0;
  double rebuilt_z_mean = 0.0;         // mean of sqrt(1 - x^2 - y^2)
  double rebuilt_z_correlation = 0.0;  // correlation of z with the rebuilt z
  double blue_min = 0.0, blue_max = 0.0;
  double rebuilt_z_min = 1.0;
  double side_max = 0.0;            // largest |x| or |y|
  double length_mean = 0.0;         // geometric mean, so that outliers of floats do not dominate
  double length_spread = 0.0;       // standard deviation of ln |v|; at 0.05, lengths agree within about 5 %
  double gradient_agreement = 0.0;  // -1..1 (vector_statistics.cpp); > 0 for green up, < 0 for green down, 0 if not a
                                    // surface
  double gradient_sample_count = 0.0;
  // The members below show whether blue is z, if z is taken from blue.
  double length_error = 0.0;           // rms of |v| - 1, weighted by x^2 + y^2, because the z of flat texels contains
                                       // no information
  double positive_length_error = 0.0;  // length error of (x, y, blue), for ZRange::kPositive
  double z_dependence = 0.0;           // correlation ratio of z on sqrt(x^2 + y^2), 0 to 1; at 1, z is a function of it
  double block_length_spread = 0.0;    // standard deviation of ln of the mean |v| of 4 x 4 texels
  double rebuilt_angle = 0.0;          // rms angle in degrees between the vector and the vector with rebuilt z
};

/// Adds statistics row by row from the top. Each row must be added once. At most about 16 Mi texels are examined, in
/// whole bands of 64 rows, evenly spaced.
class VectorStatisticsSums {
 public:
  VectorStatisticsSums(const RawImageInfo& info, const VectorEncoding& encoding);
  ~VectorStatisticsSums();
  VectorStatisticsSums(VectorStatisticsSums&& other) noexcept;

  const VectorEncoding& encoding() const;
  void add_row(const float* values);
  VectorStatistics result() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the statistics of a stored image.
VectorStatistics vector_statistics(const RawImage& image, const VectorEncoding& encoding, int threads);

}  // namespace multum
