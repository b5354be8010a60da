// SPDX-License-Identifier: Apache-2.0
// Computes the BRDF of Cook and Torrance 1982 with the facets of Torrance-Sparrow (after torrance_sparrow.glsl),
// Schlick's Fresnel term, and the shadowing and masking of V-shaped grooves. For these, G = min(1, 2 n.h n.v / v.h, 2
// n.h n.l / v.h) and V = G / (4 n.l n.v). V is computed without a division by a cosine that may be 0. If V is
// multiplied by n.l, the product is at most n.h / (2 v.h).

float multum_groove_visibility(float n_l, float n_v, float n_h, float v_h) {
  float groove = 2.0 * n_h / max(v_h, 1e-4);
  return 0.25 * min(1.0 / max(n_l * n_v, 1e-8), groove / max(max(n_l, n_v), 1e-4));
}

// Returns Schlick's approximation F0 + (1 - F0) (1 - v.h)^5 (Schlick 1994).
vec3 multum_schlick(vec3 f0, float v_h) {
  float x = clamp(1.0 - v_h, 0.0, 1.0);
  float x2 = x * x;
  return f0 + (vec3(1.0) - f0) * (x2 * x2 * x);
}

#ifdef MULTUM_FRESNEL_DIFFUSE
#ifdef MULTUM_COLOURED_PLACES
vec3 multum_f0;  // F0 at the shaded place; main() sets it before shading
#else
uniform vec3 u_f0;
#define multum_f0 u_f0
#endif

vec3 multum_fresnel(float v_h) { return multum_schlick(multum_f0, v_h); }
#endif
#ifdef MULTUM_COOK_TORRANCE
float multum_visibility(float n_l, float n_v, float n_h, float v_h) {
  return multum_groove_visibility(n_l, n_v, n_h, v_h);
}
#endif
