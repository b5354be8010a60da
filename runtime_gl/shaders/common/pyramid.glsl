// SPDX-License-Identifier: Apache-2.0
// Pyramidal parametrics (Williams 1983): the choice of the level, and where a normal lies in a reflectance map. The
// same in double: host/asset/pyramid_sample.h, reflectance_mapping.h.

// Section 3, after Heckbert: how coordinates, in texels of level 0, grow along a row and a column of pixels. The longer
// of the two lengths: the GL's own choice (OpenGL 4.5, section 8.14.1), which drivers may approximate, and do.
float multum_mip_level(vec2 along_x, vec2 along_y) {
  return 0.5 * log2(max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30));
}

// Lambert's azimuthal equal-area projection about +z of a unit normal, as s, t.
vec2 multum_reflectance_place(vec3 n) {
  float one_plus_z = n.z > 0.0 ? 1.0 + n.z : dot(n.xy, n.xy) / (1.0 - n.z);  // behind, 1 + z cancels
  return vec2(0.5) + vec2(n.x, -n.y) * (inversesqrt(max(0.5 * one_plus_z, 1e-12)) / 2.82842712);
}
