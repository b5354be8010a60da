// SPDX-License-Identifier: Apache-2.0
// Pyramidal parametrics (Williams 1983): the choice of the level, and where a normal lies in a reflectance map. The
// same in double: host/formats/asset/pyramid/pyramid_sample.h, reflectance_mapping.h.

// Section 3, after Heckbert: how coordinates, in texels of level 0, grow along a row and a column of pixels. The longer
// of the two lengths: the GL's own choice (OpenGL 4.5, section 8.14.1), which drivers may approximate, and do.
float multum_mip_level(vec2 along_x, vec2 along_y) {
  return 0.5 * log2(max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30));
}

// Lambert's azimuthal equal-area projection about +z of a unit normal, as s, t. Behind, where 1 + z cancels, from its
// length sqrt(2 (1 - z)). The normal that points straight away lies in every corner: the first is given.
vec2 multum_reflectance_place(vec3 n) {
  if (n.z > 0.0) return vec2(0.5) + vec2(n.x, -n.y) * (inversesqrt(0.5 * (1.0 + n.z)) / 2.82842712);
  float side = length(n.xy);
  return side > 1e-12 ? vec2(0.5) + vec2(n.x, -n.y) * (0.5 * sqrt(1.0 - n.z) / side) : vec2(0.0);
}
