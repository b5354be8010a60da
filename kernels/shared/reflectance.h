// SPDX-License-Identifier: Apache-2.0
// The arguments of kernels/reflectance_pyramid.cl. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_REFLECTANCE_H
#define MULTUM_KERNELS_SHARED_REFLECTANCE_H

// A distant light. The light vector and the half vector have unit length, in the map's frame (x right, y up, z towards
// the viewer).
typedef struct MultumReflectanceLight {
  float light_x, light_y, light_z, unused_light;
  float half_x, half_y, half_z, unused_half;
  float red, green, blue, unused_colour;  // irradiance on a surface that faces it
} MultumReflectanceLight;

typedef struct MultumReflectanceMap {
  int size;         // texels per side
  int sample_side;  // normals along a side of a texel; sample_side^2 normals are averaged
  int light_count;
  float exponent;  // s of Blinn-Phong
  float diffuse_red, diffuse_green, diffuse_blue, unused_diffuse;
  float specular_red, specular_green, specular_blue, unused_specular;
} MultumReflectanceMap;

#endif
