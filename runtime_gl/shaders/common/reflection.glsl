// SPDX-License-Identifier: Apache-2.0
// Defines the interface between the parts of a scene's fragment shader. Texts are joined in this order:
//
//   common/movmf_shading.glsl, common/texture_filter.glsl, this file, one of brdf/, light/environment*.glsl if there is
//   an environment, one of surface/, light/lights.glsl, scene.frag
//
// A BRDF times the cosine is k_d / pi albedo (1 - F) max(n.l, 0) + k_s F f(n.h) V max(n.l, 0). A file of brdf/ has
//
//   vec3 multum_facets(vec3 n, vec3 h)           f of one normal
//   vec3 multum_lobe_facets(vec4 lobe, vec3 h)   f convolved with a vMF lobe (a r, a), times the amplitude
//   vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l)   f(n.h) max(n.l, 0) convolved with it, times the amplitude
//   vec3 multum_fresnel(float v_h)               F, with MULTUM_FRESNEL; otherwise 1, or a factor of u_specular and
//                                                u_diffuse. F is outside the convolution: it does not depend on n.
//                                                With MULTUM_FRESNEL_DIFFUSE there is a 1 - F
//   float multum_visibility(float n_l, float n_v, float n_h, float v_h)   V, with MULTUM_VISIBILITY, otherwise 1: from
//                                                cosines or, over a lobe, from their means max(n.l, 0) and max(n.v, 0)
//
// or, with MULTUM_LAMBERT, none of these, because there is no highlight. Simpler representations use u_exponent, the
// exponent of the equally wide Blinn-Phong (1 / u_exponent is the variance of its slopes along each axis). If a
// representation defines MULTUM_ZONAL_ORDER, it gets u_zonal: a_l = integral over the sphere of f(t) P_l(t), a_0 = 1
// for a normalised f.
//
// MULTUM_TURNED: the geometry's normals turn within a pixel, as on a mesh. Representations without lobes add the
// variance of these turns, multum_turn_variance, to the normals that they fetch.
//
// MULTUM_REFERENCE: the picture is drawn many times and averaged; u_sample counts the pictures.
//
// A file of surface/ is a representation of the normals under a fragment:
//
//   struct MultumSurface                                 the fetched values
//   MultumFootprint multum_surface_footprint(vec2 st)    the footprint on its textures
//   MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint)   the filter's result there
//   MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h)   the reflection of light from l; it
//                                                        includes albedo, amplitudes, f, V and cosines, but not
//                                                        k_d / pi, k_s and F
//   MultumReflection multum_reflect_environment(MultumSurface surface, vec3 v)   the reflection of an environment, with
//                                                        MULTUM_ENVIRONMENT: multum_environment_lobe(lobe, v) returns
//                                                        it for a lobe (a r, a), F included

uniform float u_exponent;
uniform vec3 u_facet_total;  // the integral of f: 1, except for GGX and measured BRDFs
#ifdef MULTUM_ZONAL_ORDER
uniform vec3 u_zonal[MULTUM_ZONAL_ORDER + 1];
#endif

#ifdef MULTUM_ROUGHNESS
uniform float u_mean_cosine;  // mean cosine of the roughness in the normals' lengths; diffuse light does not use it
#endif

#ifdef MULTUM_REFERENCE
uniform int u_sample;
#endif

#ifdef MULTUM_TURNED
float multum_turn_variance = 0.0;  // multum_geometry_variance() at the shaded place
#endif

struct MultumReflection {
  vec3 diffuse;
  vec3 specular;
};

// Returns the half vector. For a light straight behind the surface point, no half vector exists, and the result is 0.
// Every highlight is finite at 0.
vec3 multum_half_vector(vec3 l, vec3 v) {
  vec3 sum = l + v;
  return sum / max(length(sum), 1e-6);
}

// Returns the tangent, the bitangent and the normal. If the tangent is missing or along the normal, it is replaced by
// any vector at right angles. Meshes have such tangents where their texture coordinates do not change.
mat3 multum_tangent_frame(vec3 normal, vec4 tangent) {
  vec3 n = normalize(normal);
  vec3 t = tangent.xyz - n * dot(n, tangent.xyz);
  if (dot(t, t) <= 1e-12 * max(dot(tangent.xyz, tangent.xyz), 1e-20))
    t = cross(n, abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(0.0, 1.0, 0.0));
  t = normalize(t);
  return mat3(t, cross(n, t) * tangent.w, n);
}
