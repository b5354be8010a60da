// SPDX-License-Identifier: Apache-2.0
// Draws a plane that is covered with a baked map of lobes, as the GL runtime does for one distant light. Footprints and
// levels follow runtime_gl/shaders/common/texture_filter.glsl, and shading follows
// runtime_gl/shaders/surface/movmf.glsl. Each tap is shaded on its own.

#include "device/numerics.clh"
#include "device/vmf_lit.clh"
#include "shared/plane_picture.h"

#if MULTUM_VECTOR_WIDTH != 1
#error "plane_picture has only a scalar variant"
#endif
#ifndef MULTUM_LOBES
#define MULTUM_LOBES 4
#endif

#define TAP_OVERLAP 0.594603558f  // 2^-0.75

static inline float3 vector_of(const float* v) { return (float3)(v[0], v[1], v[2]); }

// Returns the texel at place i, or -1 beyond a black border.
static inline int wrapped(int i, int size, int mode) {
  if (mode == 0) return i < 0 || i >= size ? -1 : i;
  if (mode == 1) return clamp(i, 0, size - 1);
  const int period = mode == 2 ? size : 2 * size;
  const int turn = (i % period + period) % period;
  return turn < size ? turn : period - 1 - turn;
}

typedef struct Surface {
  float4 lobes[MULTUM_LOBES];    // (a r, a)
  float3 colours[MULTUM_LOBES];  // a times linear RGB
} Surface;

// Adds one level, filtered linearly, to the surface.
static void add_level(Surface* surface, __global const float4* lobes, __global const float* colours, float2 st,
                      int level, float share, const MultumPlanePicture* view) {
  const int width = max(view->map_width >> level, 1), height = max(view->map_height >> level, 1);
  const float x = clamp(st.x * width - 0.5f, -1e9f, 1e9f), y = clamp(st.y * height - 0.5f, -1e9f, 1e9f);
  const int left = (int)floor(x), top = (int)floor(y);
  const float right_share = x - left, lower_share = y - top;
  for (int k = 0; k < 4; ++k) {
    const int column = wrapped(left + (k & 1), width, view->wrap_s);
    const int row = wrapped(top + (k >> 1), height, view->wrap_t);
    if (column < 0 || row < 0) continue;
    const float weight =
        share * ((k & 1) != 0 ? right_share : 1.0f - right_share) * ((k >> 1) != 0 ? lower_share : 1.0f - lower_share);
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      const size_t texel = ((size_t)j * height + row) * width + column;
      surface->lobes[j] += weight * lobes[texel];
      if (view->has_colours != 0) surface->colours[j] += weight * vload3(texel, colours);
    }
  }
}

static inline float3 fresnel(__global const float4* table, float v_h) {
  const float x = clamp(v_h, 0.0f, 1.0f) * MULTUM_PLANE_FRESNEL_STEPS;
  const int i = min((int)x, MULTUM_PLANE_FRESNEL_STEPS - 1);
  return mix(table[i].xyz, table[i + 1].xyz, x - i);
}

static inline float visibility_of(const MultumPlanePicture* view, float n_l, float n_v, float n_h, float v_h) {
  if (view->visibility == MULTUM_PLANE_V_SMITH) {
    const float x = view->alpha * view->alpha;
    const float masking = n_l * sqrt(fma(n_v * n_v, 1.0f - x, x)), shadowing = n_v * sqrt(fma(n_l * n_l, 1.0f - x, x));
    return 0.5f / max(masking + shadowing, 1e-6f);
  }
  if (view->visibility == MULTUM_PLANE_V_GROOVES) {
    const float groove = 2.0f * n_h / max(v_h, 1e-4f);
    return 0.25f * min(1.0f / max(n_l * n_v, 1e-8f), groove / max(max(n_l, n_v), 1e-4f));
  }
  return 0.25f / max(n_l + n_v - n_l * n_v, 1e-6f);
}

static inline float sum_of(float3 c) { return c.x + c.y + c.z; }

// Returns the highlight of a lobe, without F and k_s. The formulas are those of facets_of() and visibility() in
// host/api/lobe_shading.cpp.
static float3 highlight_of(float4 lobe, float3 h, float3 l, float3 v, float v_h, const MultumPlanePicture* view) {
  const float e = one_minus_cosine(lobe, h), d = lobe_spread(lobe);
  const float4 light = (float4)(l, view->mean_cosine), eye = (float4)(v, view->mean_cosine);
  float3 density = (float3)(0.0f), with_light = (float3)(0.0f), with_view = (float3)(0.0f);
  for (int i = 0; i < view->term_count; ++i) {
    const float shape = view->is_blinn_phong != 0
                            ? shade_blinn_phong(blinn_phong_lobe(lobe, view->exponent), e)
                            : lobe.w * vmf_density(vmf_shape(shading_kappa(d + (1.0f - d) * view->spreads[i])), e);
    const float3 part = shape * vector_of(view->weights[i]);
    const float facets = shading_kappa(view->spreads[i]);
    density += part;
    with_light += part * lit_cosine(lobe, h, light, facets);
    if (view->visibility != MULTUM_PLANE_V_ONE) with_view += part * lit_cosine(lobe, h, eye, facets);
  }
  density = max(density, 0.0f);
  with_light = max(with_light, 0.0f);
  if (view->visibility == MULTUM_PLANE_V_ONE) return with_light;
  const float total = max(sum_of(density), 1e-20f);
  const float n_l = clamp(sum_of(with_light) / total, 0.0f, 1.0f);
  const float n_v = clamp(sum_of(max(with_view, 0.0f)) / total, 0.0f, 1.0f);
  const float size = sqrt(dot(lobe.xyz, lobe.xyz));
  const float3 mean = size > 1e-12f ? lobe.xyz / size : (float3)(0.0f, 0.0f, 1.0f);
  const float3 n = d * h + mean / max(view->exponent, 1e-6f);
  const float n_size = sqrt(dot(n, n));
  const float n_h = n_size > 1e-6f ? max(dot(n, h), 0.0f) / n_size : 0.0f;
  return with_light * visibility_of(view, n_l, n_v, n_h, v_h);
}

static float3 shade(const Surface* surface, float3 l, float3 v, __global const float4* fresnel_table,
                    const MultumPlanePicture* view) {
  if (l.z <= 0.0f || v.z <= 0.0f) return (float3)(0.0f);
  const float3 half_vector = l + v;
  const float3 h = half_vector / max(sqrt(dot(half_vector, half_vector)), 1e-12f);
  const float v_h = max(dot(v, h), 0.0f);
  const float3 f = fresnel(fresnel_table, v_h);
  float3 diffuse = (float3)(0.0f), specular = (float3)(0.0f);
  for (int j = 0; j < MULTUM_LOBES; ++j) {
    const float4 lobe = surface->lobes[j];
    if (lobe.w <= AMPLITUDE_SHADED_MIN) continue;
    const float3 colour =
        view->has_colours != 0 ? surface->colours[j] / max(lobe.w, AMPLITUDE_SHADED_MIN) : (float3)(1.0f);
    diffuse += colour * shade_lambert(without_roughness(lobe, view->mean_cosine), l);
    specular += highlight_of(lobe, h, l, v, v_h, view);
  }
  float3 albedo = view->has_colours != 0 ? (float3)(1.0f) : vector_of(view->diffuse);
  if (view->has_diffuse_fresnel != 0) albedo *= 1.0f - f;
  return albedo * diffuse * (2.0f * INVERSE_TWO_PI) + vector_of(view->specular) * f * specular;
}

// One work-item draws one pixel, if the pixel belongs to view.level. The global size is width * height.
//   finer, coarser     [lobe][row][column]     lobes (a r, a) of view.level and of the next level
//   finer_colours, coarser_colours             a times linear RGB, unused without colours
//   fresnel_table      [MULTUM_PLANE_FRESNEL_STEPS + 1]   F for v.h from 0 to 1
//   picture            [height * width]        written: linear RGB, and 1 where the plane is visible
__kernel void plane_picture(MultumPlanePicture view, __global const float4* finer, __global const float4* coarser,
                            __global const float* finer_colours, __global const float* coarser_colours,
                            __global const float4* fresnel_table, __global float4* picture) {
  const int pixel = (int)get_global_id(0);
  if (pixel >= view.width * view.height) return;
  const float x = pixel % view.width + 0.5f, y = pixel / view.width + 0.5f;
  const float3 along_x = vector_of(view.along_x), along_y = vector_of(view.along_y);
  const float3 ray = vector_of(view.corner) + x * along_x + y * along_y;
  const float3 eye = vector_of(view.eye);
  if (ray.z > -1e-6f || eye.z <= 0.0f) return;
  // The ray meets the plane at eye + t ray, and t' = -t ray_z' / ray_z.
  const float t = -eye.z / ray.z;
  const float2 size = (float2)(view.map_width, view.map_height);
  const float2 st = (float2)(eye.x + t * ray.x, 1.0f - (eye.y + t * ray.y));
  const float2 st_x = t * (float2)(along_x.x - ray.x * along_x.z / ray.z, ray.y * along_x.z / ray.z - along_x.y);
  const float2 st_y = t * (float2)(along_y.x - ray.x * along_y.z / ray.z, ray.y * along_y.z / ray.z - along_y.y);
  const float2 texels_x = st_x * size, texels_y = st_y * size;
  const float length_x = sqrt(dot(texels_x, texels_x)), length_y = sqrt(dot(texels_y, texels_y));
  const float longer = max(length_x, length_y), shorter = min(length_x, length_y);
  const float ratio = min(longer / max(shorter, 1e-20f), (float)view.taps);
  const int count = max((int)ceil(ratio - 1e-3f), 1);
  const float width = count == 1 ? longer : max(shorter, longer / count * TAP_OVERLAP);
  const float lod = clamp(log2_v(max(width, 1e-15f)), (float)view.first_level, (float)view.last_level);
  const int level = min((int)lod, view.last_level);
  if (level != view.level) return;
  const float2 step = (length_x > length_y ? st_x : st_y) / count;
  const float3 v = -ray / sqrt(dot(ray, ray)), l = vector_of(view.light);
  float3 sum = (float3)(0.0f);
  for (int i = 0; i < count; ++i) {
    const float2 place = st + (i - 0.5f * (count - 1)) * step;
    Surface surface;
    for (int j = 0; j < MULTUM_LOBES; ++j) {
      surface.lobes[j] = (float4)(0.0f);
      surface.colours[j] = (float3)(0.0f);
    }
    add_level(&surface, finer, finer_colours, place, level, 1.0f - (lod - level), &view);
    if (lod > level) add_level(&surface, coarser, coarser_colours, place, level + 1, lod - level, &view);
    sum += shade(&surface, l, v, fresnel_table, &view);
  }
  picture[pixel] = (float4)(sum / count, 1.0f);
}
