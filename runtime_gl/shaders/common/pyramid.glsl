// SPDX-License-Identifier: Apache-2.0
// Computes two parts of pyramidal parametrics (Williams 1983), which are the choice of the level, and the place of a
// normal in a reflectance map. host/formats/asset/pyramid/pyramid_sample.h and reflectance_mapping.h contain the same
// computations in double precision.

// Returns the level from the growth of coordinates, in texels of level 0, along a row and a column of pixels (section
// 3, after Heckbert). Uses the longer of the two lengths, as GL does (OpenGL 4.5, section 8.14.1). Drivers are allowed
// to approximate the level, and do so.
float multum_mip_level(vec2 along_x, vec2 along_y) {
  return 0.5 * log2(max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30));
}

// Returns s, t of a unit normal in Lambert's azimuthal equal-area projection about +z. For z < 0, where 1 + z cancels,
// uses the length sqrt(2 (1 - z)). The normal that points straight away is in every corner, and its result is the first
// corner.
vec2 multum_reflectance_place(vec3 n) {
  if (n.z > 0.0) return vec2(0.5) + vec2(n.x, -n.y) * (inversesqrt(0.5 * (1.0 + n.z)) / 2.82842712);
  float side = length(n.xy);
  return side > 1e-12 ? vec2(0.5) + vec2(n.x, -n.y) * (0.5 * sqrt(1.0 - n.z) / side) : vec2(0.0);
}
