// SPDX-License-Identifier: Apache-2.0
// Decodes the values of a file to unit normals after their meaning is known, and repairs texels without a normal.
#pragma once

#include <cmath>
#include <string>

#include <glm/vec3.hpp>

#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/raw_image.h"

namespace multum {

struct VectorEncoding {
  bool is_signed = false;        // true if a component is the value v itself, false if it is v * 2 - 1
  bool rebuild_z = false;        // true for z = sqrt(1 - x^2 - y^2); blue is ignored
  bool positive_z = false;       // true for unsigned values whose blue is z itself (ZRange::kPositive)
  bool empty_is_unused = false;  // true if texels for which is_empty() holds were never written
  bool flat_pair = false;        // for 8 bits: true if a texel whose red and green are both 127 or 128 has x = y = 0
  GreenAxis green = GreenAxis::kUp;
  float tilt = 1.0f;  // scale of x and y of the whole vector: NormalMapSettings::normal_scale

  bool operator==(const VectorEncoding&) const = default;
};

/// The smallest z of a unit normal, 1/512. Below it, the slope x/z is meaningless. The smallest positive z in an 8-bit
/// file is 1/255. If the vector has the largest possible length, sqrt(3), normalising it makes this z 0.0023. Therefore
/// every 8-bit normal above the surface stays unchanged, and every 8-bit normal below the surface is lifted.
constexpr double kHorizonZ = 1.0 / 512.0;

/// Decodes v / 255 * 2 - 1, as every GPU does. No code is then 0, because 127 and 128 are -+0.0039. Tools write either
/// code for 0, so 127.5 is the unbiased choice. (Among the measured lossless maps, the mean slopes suggest 127 for four
/// maps and 128 for two maps; all are within half a code of 127.5.) But a flat texel is (127|128, 127|128, 255) in all
/// maps, and up to half of the texels of a map are flat. Such a texel is read as exactly flat instead of tilted by 0.3
/// degrees.
inline glm::dvec3 decode_vector(const VectorEncoding& encoding, float r, float g, float b) {
  glm::dvec3 v(r, g, b);
  if (!encoding.is_signed)
    v = glm::dvec3(v.x * 2.0 - 1.0, v.y * 2.0 - 1.0, encoding.positive_z ? v.z : v.z * 2.0 - 1.0);
  constexpr double kHalfCode = 1.01 / 255.0;
  if (encoding.flat_pair && std::abs(v.x) < kHalfCode && std::abs(v.y) < kHalfCode) v.x = v.y = 0.0;
  if (encoding.rebuild_z) v.z = std::sqrt(std::fmax(0.0, 1.0 - v.x * v.x - v.y * v.y));
  if (encoding.green == GreenAxis::kDown) v.y = -v.y;
  v.x *= static_cast<double>(encoding.tilt);
  v.y *= static_cast<double>(encoding.tilt);
  return v;
}

/// Returns false for NaN, infinities, and values that occur only in broken pixels of a renderer, never in scaled
/// normals.
inline bool is_vector_value(float v) { return std::abs(v) <= 1e9f; }

/// Returns true if a texel of an unsigned file was never written. The area between the charts of an atlas is black, up
/// to the noise of lossy compression (4 codes of 8 bits), and no normal is near (-1, -1, -1).
inline bool is_unused(const VectorEncoding& encoding, float r, float g, float b) {
  constexpr float kBlackMax = 4.5f / 255.0f;
  return !encoding.is_signed && r <= kBlackMax && g <= kBlackMax && b <= kBlackMax && r >= 0.0f && g >= 0.0f &&
         b >= 0.0f;
}

/// Returns true if a texel of a signed or float file was never written. Painters and bakers leave 0 or NaN outside
/// charts. Single texels of this kind are faults of a renderer and are repaired. If z is rebuilt, a texel of 0 is flat.
inline bool is_empty(const VectorEncoding& encoding, float r, float g, float b) {
  if (std::isnan(r)) return std::isnan(g) && (encoding.rebuild_z || std::isnan(b));
  return encoding.is_signed && !encoding.rebuild_z && r == 0.0f && g == 0.0f && b == 0.0f;
}

/// Decodes an image of 2 or 3 channels in bands, with at most a few bands per thread in memory. Fills in the counts of
/// the report, but not its encoding. Throws Error(kInput) if more than repair_share_max of the texels need repair, or
/// if too many are black. Throws Error(kEnvironment) if scratch files cannot be written. The work can be cancelled
/// between bands.
NormalMapRows decode_normals(const std::string& path, const RawImage& image, const VectorEncoding& encoding,
                             const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                             Progress* progress);

/// Throws Error(kInput) with the counts if they exceed settings.repair_share_max of all texels. The message ends with
/// `hint`.
void check_repair_share(const std::string& path, const NormalMapRows& map, const NormalMapSettings& settings,
                        const std::string& hint = "");

/// Turns a normal of any length into a unit normal with z >= kHorizonZ. Returns false if z was lifted.
inline bool normalise_above_horizon(glm::dvec3& n) {
  n /= std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  if (n.z >= kHorizonZ) return true;
  const double xy = std::sqrt(n.x * n.x + n.y * n.y);
  if (xy == 0.0) {  // the normal points straight down and has no side to project to
    n = glm::dvec3(0.0, 0.0, 1.0);
    return false;
  }
  const double scale = std::sqrt(1.0 - kHorizonZ * kHorizonZ) / xy;
  n = glm::dvec3(n.x * scale, n.y * scale, kHorizonZ);
  return false;
}

}  // namespace multum
