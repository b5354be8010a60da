// SPDX-License-Identifier: Apache-2.0
// Shades spherical harmonics of the normals, in an array of textures with trilinear filtering (common/sh_shading.glsl).
// With MULTUM_COLOURS, the map has colours. With MULTUM_NORMAL_MAP, levels finer than the stored ones come from the
// normal map, as a lobe. With MULTUM_ALBEDO_MAP, this lobe has its own colours. With MULTUM_BLACK_S or MULTUM_BLACK_T,
// there is no material beyond that border. With MULTUM_ROUGHNESS, the coefficients include the BRDF's width. With
// MULTUM_BASIS k, everything is multiplied by weight k.
//
// The highlight's cosine max(n . l, 0) also depends on n. It is replaced by one of
//   MULTUM_SH_IRRADIANCE  its mean over all normals
//   MULTUM_SH_DIRECTION   the cosine of the mean normal's direction
//   (neither)             the cosine of the mean normal, shorter than 1
uniform sampler2DArray u_harmonics;
#ifdef MULTUM_COLOURS
uniform sampler2D u_colours;
#endif
#ifdef MULTUM_ROUGHNESS
uniform vec3 u_diffuse_zonal[MULTUM_SH_ORDER + 1];  // coefficients of max(n . l, 0), divided by the mean roughness
#endif
#ifdef MULTUM_BASIS
uniform sampler2D u_weights;
#endif
#ifdef MULTUM_NORMAL_MAP
uniform sampler2D u_normal_map;  // mean normals of the levels finer than those stored; w = 0 beyond a black border
#endif
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif

struct MultumSurface {
  vec4 parts[MULTUM_SH_PARTS];
  float share;  // share of the stored levels; their coefficients do not include this factor
  float material;  // includes the weight; 0 beyond a black border
  vec3 albedo;
#ifdef MULTUM_NORMAL_MAP
  vec4 finest;  // a lobe that includes its share
  vec3 finest_albedo;
#endif
};

MultumFootprint multum_surface_footprint(vec2 st) { return multum_footprint(u_harmonics, st); }
ivec2 multum_surface_size() { return textureSize(u_harmonics, 0).xy; }

MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  MultumSurface surface;
  for (int i = 0; i < MULTUM_SH_PARTS; ++i)
    surface.parts[i] = multum_filtered(u_harmonics, st, float(i), footprint);
  surface.share = surface.material = 1.0;
#ifdef MULTUM_BLACK_S
  surface.material *= step(abs(st.x - 0.5), 0.5);
#endif
#ifdef MULTUM_BLACK_T
  surface.material *= step(abs(st.y - 0.5), 0.5);
#endif
#ifdef MULTUM_BASIS
  surface.material *= multum_filtered(u_weights, st, footprint)[MULTUM_BASIS];
#endif
  surface.albedo = vec3(1.0);
#ifdef MULTUM_COLOURS
  surface.albedo = multum_filtered(u_colours, st, footprint).rgb;
#endif
#ifdef MULTUM_NORMAL_MAP
  ivec2 size = textureSize(u_harmonics, 0).xy;
  MultumFootprint on_map = multum_footprint_on(footprint, size, textureSize(u_normal_map, 0));
  float map_share = multum_normal_map_share(footprint.level);
  surface.finest = map_share * multum_normal_map_lobe(u_normal_map, st, on_map);
  surface.share -= map_share;
  surface.finest_albedo = surface.albedo;  // colour of the first stored level, the finest known
#ifdef MULTUM_ALBEDO_MAP
  surface.finest_albedo = multum_filtered(u_albedo_map, st, on_map).rgb;
#endif
#endif
  surface.share *= surface.material;
  return surface;
}

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
#ifdef MULTUM_ROUGHNESS
  float diffuse = multum_sh_facets(surface.parts, 1.0, l, u_diffuse_zonal).x;
#else
  float diffuse = multum_sh_lambert(surface.parts, 1.0, l);
#endif
  MultumReflection sum = MultumReflection(surface.share * surface.albedo * diffuse, vec3(0.0));
#ifndef MULTUM_LAMBERT
  vec3 mean = multum_sh_mean_normal(surface.parts);
  vec3 n = mean / max(length(mean), 1e-6);
#if defined(MULTUM_SH_IRRADIANCE)
  float cosine = diffuse;
#elif defined(MULTUM_SH_DIRECTION)
  float cosine = max(dot(n, l), 0.0);
#else
  float cosine = max(dot(mean, l), 0.0);
#endif
  sum.specular = surface.share * cosine * multum_sh_facets(surface.parts, 1.0, h, u_zonal);
#ifdef MULTUM_VISIBILITY
  sum.specular *= multum_visibility(max(dot(n, l), 0.0), max(dot(n, v), 0.0), max(dot(n, h), 0.0), dot(v, h));
#endif
#endif
#ifdef MULTUM_NORMAL_MAP
  vec4 lobe = surface.material * surface.finest;
#ifdef MULTUM_ROUGHNESS
  vec4 of_normals = multum_movmf_without_roughness(lobe, u_mean_cosine);
#else
  vec4 of_normals = lobe;
#endif
  sum.diffuse += surface.finest_albedo * multum_movmf_lambert(of_normals, l);
#ifndef MULTUM_LAMBERT
#ifdef MULTUM_ROUGHNESS
  float facet_kappa = multum_vmf_kappa(1.0 - u_mean_cosine);
  vec3 finest_specular = multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(of_normals, h, l, facet_kappa);
#else
  vec3 finest_specular = multum_lobe_highlight(lobe, h, l);
#endif
#ifdef MULTUM_VISIBILITY
  vec3 finest_n = multum_movmf_mean_direction(lobe);
  finest_specular *= multum_visibility(max(dot(finest_n, l), 0.0), max(dot(finest_n, v), 0.0),
                                       max(dot(finest_n, h), 0.0), dot(v, h));
#endif
  sum.specular += finest_specular;
#endif
#endif
  return sum;
}

#ifdef MULTUM_ENVIRONMENT
// Returns the environment's diffuse light, L(n) = mean + linear . n + n . quadratic n (light/environment.glsl),
// integrated over the normals. The computation needs E[n] and E[n n^T], which the bands contain. The result is exact up
// to l = 2, and only 1 % of Lambert's light is in higher orders. The quadratic part has no trace, so for rough normals,
// bands 1 and 2 are scaled in the same way as for other light.
vec3 multum_sh_irradiance(vec4 parts[MULTUM_SH_PARTS]) {
  vec3 mean = multum_environment_frame * multum_sh_mean_normal(parts);
  mat3 second = multum_environment_frame * multum_sh_second_moments(parts) * transpose(multum_environment_frame);
#if defined(MULTUM_ROUGHNESS) && MULTUM_SH_ORDER >= 2
  float linear = u_diffuse_zonal[1].x, quadratic = u_diffuse_zonal[2].x;
#elif defined(MULTUM_ROUGHNESS)
  float linear = u_diffuse_zonal[1].x, quadratic = 0.0;
#else
  float linear = 2.0 / 3.0 * MULTUM_PI, quadratic = 0.25 * MULTUM_PI;
#endif
  vec3 sum = MULTUM_PI * u_smooth_mean;
  for (int c = 0; c < 3; ++c) {
    sum[c] += linear * dot(u_smooth_linear[c], mean);
    for (int row = 0; row < 3; ++row) sum[c] += quadratic * dot(u_smooth_quadratic[3 * c + row], second[row]);
  }
  return max(sum, vec3(0.0));
}

#if defined(MULTUM_ENVIRONMENT_SH) && !defined(MULTUM_ROUGHNESS)
const vec2 multum_sh_nodes[MULTUM_SH_ORDER + 1] = MULTUM_SH_NODES;  // z and weight

// Computes the highlight by Han et al. 2007, section 8: the sum over l and m of a_l(f) g_lm L'_lm. The normals g are in
// tangent space, and L' is in the environment's frame. Instead of rotating coefficients, their product is integrated
// over the sphere. Nodes of Gauss and Legendre, with equal steps around the z axis, are exact for this product. The
// cosine and the other factors that depend on the normal are those of each node.
vec3 multum_sh_environment_specular(vec4 parts[MULTUM_SH_PARTS], vec3 v) {
  vec3 light[MULTUM_SH_COUNT + 1];
  for (int i = 0; i <= MULTUM_SH_COUNT; ++i) {
    int l = int(sqrt(float(i) + 0.5));
    light[i] = l > MULTUM_VMF_ZONAL_ORDER ? vec3(0.0)
                                          : u_half_zonal[min(l, MULTUM_VMF_ZONAL_ORDER)] * multum_half_vector_light(i);
  }
  const int turns = 2 * MULTUM_SH_ORDER + 1;
  vec3 sum = vec3(0.0);
  for (int node = 0; node <= MULTUM_SH_ORDER; ++node) {
    float z = multum_sh_nodes[node].x, side = sqrt(1.0 - z * z);
    for (int turn = 0; turn < turns; ++turn) {
      float angle = 2.0 * MULTUM_PI * float(turn) / float(turns);
      vec3 d = vec3(side * cos(angle), side * sin(angle), z);
      // Limits the quotient, which can be very large for directions that face away from the viewer.
      vec3 share = min(multum_reflection_quotient(d, 0.0, v), vec3(8.0));
      float bands[MULTUM_SH_ORDER + 1], density = 0.0;
      multum_sh_bands(parts, 1.0, d, bands);
      for (int l = 0; l <= MULTUM_SH_ORDER; ++l) density += bands[l];
      sum += multum_sh_nodes[node].y * density * share * multum_sh_colour(light, multum_environment_frame * d);
    }
  }
  return max(sum, vec3(0.0));
}
#endif

// With MULTUM_ROUGHNESS, or with prefiltered levels of the environment, the highlight is that of a lobe around the mean
// normal.
MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v) {
  MultumReflection sum = multum_environment_lobe(vec4(multum_sh_mean_normal(surface.parts), 1.0), v);
#if defined(MULTUM_ENVIRONMENT_SH) && !defined(MULTUM_ROUGHNESS)
  sum.specular = multum_sh_environment_specular(surface.parts, v);
#endif
#ifndef MULTUM_FRESNEL_DIFFUSE
  sum.diffuse = multum_sh_irradiance(surface.parts);
#endif
  sum.diffuse *= surface.share * surface.albedo;
  sum.specular *= surface.share;
#ifdef MULTUM_NORMAL_MAP
  MultumReflection finest = multum_environment_lobe(surface.material * surface.finest, v);
  sum.diffuse += surface.finest_albedo * finest.diffuse;
  sum.specular += finest.specular;
#endif
  return sum;
}
#endif
