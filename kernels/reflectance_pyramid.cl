// SPDX-License-Identifier: Apache-2.0
// Computes the finest level of a reflectance map (Williams 1983, section 4). For each normal, the map holds the light
// that a surface under distant lights sends to a distant viewer. kernels/mip_box.cl builds the pyramid from it.
//
//   radiance(n) = sum over lights E ( k_d / pi + k_s (s + 1) / (2 pi) max(n.h, 0)^s ) max(n.l, 0)
//
// runtime_gl/shaders/scene.frag has the same formula. Williams paints the reflected lights of his map by hand. Here
// they are computed with Blinn-Phong. A texel is the mean over sample_side^2 normals, which are evenly spread over the
// texel in the map's equal-area projection (host/formats/asset/pyramid/reflectance_mapping.h). A highlight narrower
// than a texel thus keeps its energy.

#include "device/vmf_shading.clh"
#include "shared/mip_box.h"
#include "shared/reflectance.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "reflectance_pyramid has only a scalar variant"
#endif

#define INVERSE_PI 0.318309886f
#define MAP_SIDE 2.82842712f  // side of the square, in the projection's units

// Returns the unit normal at p of Lambert's azimuthal equal-area projection about +z. Beyond the corners, returns the
// antipode.
static float3 normal_at(float px, float py) {
  const float square = min(fma(px, px, py * py), 4.0f);
  const float flat = sqrt(fma(-0.25f, square, 1.0f));
  return (float3)(px * flat, py * flat, fma(-0.5f, square, 1.0f));
}

// One work-item handles one texel of a band of rows. The global size is row_count * map_width.
//   lights [light_count]
//   nodes  [plane][row][row_length]   written: red, green, blue of the texels
// The kernel is compute bound: light_count * sample_side^2 evaluations per texel.
__kernel void reflectance_texels(__global const MultumReflectanceLight* lights, __global float* nodes,
                                 MultumReflectanceMap map, MultumBoxBand band) {
  const int item = (int)get_global_id(0);
  if (item >= band.row_count * band.map_width) return;
  const int row = item / band.map_width, column = item % band.map_width;
  const float step = MAP_SIDE / ((float)map.size * (float)map.sample_side);
  const float middle = 0.5f * (float)(map.size * map.sample_side);
  float diffuse[3] = {0.0f, 0.0f, 0.0f}, diffuse_carry[3] = {0.0f, 0.0f, 0.0f};
  float specular[3] = {0.0f, 0.0f, 0.0f}, specular_carry[3] = {0.0f, 0.0f, 0.0f};
  for (int j = 0; j < map.sample_side; ++j)
    for (int i = 0; i < map.sample_side; ++i) {
      const float3 n = normal_at(((float)(column * map.sample_side + i) + 0.5f - middle) * step,
                                 (middle - (float)((band.first_row + row) * map.sample_side + j) - 0.5f) * step);
      for (int k = 0; k < map.light_count; ++k) {
        const MultumReflectanceLight light = lights[k];
        const float cosine = fma(n.x, light.light_x, fma(n.y, light.light_y, n.z * light.light_z));
        if (cosine <= 0.0f) continue;
        const float facets = blinn_phong(
            map.exponent, one_minus_cosine((float4)(n, 1.0f), (float3)(light.half_x, light.half_y, light.half_z)));
        const float irradiance[3] = {light.red, light.green, light.blue};
        for (int c = 0; c < 3; ++c) {
          add_compensated(&diffuse[c], &diffuse_carry[c], irradiance[c] * cosine);
          add_compensated(&specular[c], &specular_carry[c], irradiance[c] * (facets * cosine));
        }
      }
    }
  const float share = 1.0f / (float)(map.sample_side * map.sample_side);
  const float k_d[3] = {map.diffuse_red, map.diffuse_green, map.diffuse_blue};
  const float k_s[3] = {map.specular_red, map.specular_green, map.specular_blue};
  const size_t plane_size = (size_t)band.row_count * band.row_length;
  __global float* out = nodes + (size_t)row * band.row_length + column;
  for (int c = 0; c < 3; ++c)
    out[c * plane_size] =
        share * fma(k_d[c] * INVERSE_PI, diffuse[c] + diffuse_carry[c], k_s[c] * (specular[c] + specular_carry[c]));
}
