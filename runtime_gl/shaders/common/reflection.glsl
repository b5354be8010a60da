// SPDX-License-Identifier: Apache-2.0
// What the parts of a scene's fragment shader say to each other. Texts are put together in this order:
//
//   common/movmf_shading.glsl, common/texture_filter.glsl, this file, one of brdf/, light/environment*.glsl if there is
//   an environment, one of surface/, light/lights.glsl, scene.frag
//
// A BRDF times the cosine is k_d / pi albedo (1 - F) max(n.l, 0) + k_s F f(n.h) V max(n.l, 0). A file of brdf/ has
//
//   vec3 multum_facets(vec3 n, vec3 h)           f of one normal
//   vec3 multum_lobe_facets(vec4 lobe, vec3 h)   f convolved with a vMF lobe (a r, a), amplitude in
//   vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l)   f(n.h) max(n.l, 0) convolved with it, amplitude in
//   vec3 multum_fresnel(float v_h)               F, with MULTUM_FRESNEL; without, 1, or a number in u_specular and
//                                                u_diffuse. What does not depend on n stands outside the convolution.
//                                                MULTUM_FRESNEL_DIFFUSE: there is a 1 - F
//   float multum_visibility(float n_l, float n_v, float n_h, float v_h)   V, of cosines or, over a lobe, of their means
//                                                max(n.l, 0) and max(n.v, 0); with MULTUM_VISIBILITY; without, 1
//
// or, with MULTUM_LAMBERT, none of these: there is no highlight. Representations that take less than that have
// u_exponent, the exponent of the Blinn-Phong that is as wide (1 / u_exponent is the variance of its slopes along each
// axis), and with MULTUM_ZONAL_ORDER, which such a representation defines, u_zonal: a_l = integral over the sphere of
// f(t) P_l(t), a_0 = 1 for what is normalised.
//
// MULTUM_TURNED: the geometry's normals turn within a pixel, as a mesh's do. What has no lobes adds the variance of
// that, multum_turn_variance, to the normals that it fetched.
//
// MULTUM_REFERENCE is drawn many times and averaged: u_sample counts them.
//
// A file of surface/ is a representation of the normals under a fragment:
//
//   struct MultumSurface                                 what was fetched
//   MultumFootprint multum_surface_footprint(vec2 st)    of its textures
//   MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint)   what the filter returns there
//   MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h)   of light from l; in it are albedo,
//                                                        amplitudes, f, V and cosines; k_d / pi, k_s and F are not
//   MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v)   of light from everywhere, with
//                                                        MULTUM_ENVIRONMENT: multum_environment_lobe(lobe, v) has it of
//                                                        a lobe (a r, a), F included

uniform float u_exponent;
uniform vec3 u_facet_total;  // the integral of f: 1, but for GGX and what was measured
#ifdef MULTUM_ZONAL_ORDER
uniform vec3 u_zonal[MULTUM_ZONAL_ORDER + 1];
#endif

#ifdef MULTUM_ROUGHNESS
uniform float u_mean_cosine;  // of the roughness that is in the lengths of normals: diffuse light is without
#endif

#ifdef MULTUM_REFERENCE
uniform int u_sample;
#endif

#ifdef MULTUM_TURNED
float multum_turn_variance = 0.0;  // multum_geometry_variance() of the place that is shaded
#endif

struct MultumReflection {
  vec3 diffuse;
  vec3 specular;
};

// Of a light straight behind what is looked at there is none: 0, at which every highlight is finite.
vec3 multum_half_vector(vec3 l, vec3 v) {
  vec3 sum = l + v;
  return sum / max(length(sum), 1e-6);
}

// Tangent, bitangent, normal. For a tangent along the normal, or none, as meshes have where their coordinates do not
// change: any at right angles.
mat3 multum_tangent_frame(vec3 normal, vec4 tangent) {
  vec3 n = normalize(normal);
  vec3 t = tangent.xyz - n * dot(n, tangent.xyz);
  if (dot(t, t) <= 1e-12 * max(dot(tangent.xyz, tangent.xyz), 1e-20))
    t = cross(n, abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0));
  t = normalize(t);
  return mat3(t, cross(n, t) * tangent.w, n);
}
