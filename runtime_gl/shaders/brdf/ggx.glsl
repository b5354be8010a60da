// SPDX-License-Identifier: Apache-2.0
// Computes GGX for one normal as in glTF 2.0 (appendix B; Walter et al. 2007), where alpha = roughness^2. Needs
// Schlick's term of cook_torrance.glsl. ggx_lobe.glsl has GGX convolved with lobes.

// Returns D = alpha^2 / (pi (1 - t^2 (1 - alpha^2))^2), where e = 1 - t. The form 1 - t^2 = e (2 - e) avoids
// cancellation near t = 1.
float multum_ggx(float alpha, float e) {
  if (e >= 1.0) return 0.0;
  float t = 1.0 - e;
  float x = alpha * alpha;
  float y = x * t * t + e * (2.0 - e);
  return x / (MULTUM_PI * y * y);
}

// Returns Smith's correlated masking and shadowing, divided by 4 n.l n.v (Heitz 2014).
float multum_smith_visibility(float alpha, float n_l, float n_v) {
  float x = alpha * alpha;
  float masking = n_l * sqrt(n_v * n_v * (1.0 - x) + x);
  float shadowing = n_v * sqrt(n_l * n_l * (1.0 - x) + x);
  return 0.5 / max(masking + shadowing, 1e-6);
}

#ifdef MULTUM_GGX
uniform float u_alpha;
#ifdef MULTUM_ROUGHNESS_TEXTURE
float multum_alpha;  // alpha at the shaded place; surface/roughness_texture.glsl sets it before shading
#else
#define multum_alpha u_alpha
#endif

vec3 multum_facets(vec3 n, vec3 h) { return vec3(multum_ggx(multum_alpha, multum_one_minus_cosine(n, h))); }

float multum_visibility(float n_l, float n_v, float n_h, float v_h) {
  return multum_smith_visibility(multum_alpha, n_l, n_v);
}
#endif
