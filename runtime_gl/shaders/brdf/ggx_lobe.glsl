// SPDX-License-Identifier: Apache-2.0
// GGX over a vMF lobe as one term, for any roughness, which may come from a texture (behind movmf_shading.glsl and
// ggx.glsl). host/formats/brdf/ggx_lobe.h has the formula and makes the table, 32 x 32 RGBA16F, linear filter, clamped:
//
//     vec4 shape = multum_ggx_lobe_shape(ggx_lobe_table, alpha, d);      // d = multum_movmf_spread(lobe)
//     float facets = lobe.w * multum_ggx_lobe_density(shape, alpha, d, e);   // e = 1 - mu.h
//
// Over all roughnesses and lobes it is within 4.5 % of the exact convolution, relative L1 over the sphere of h
// (tests/gl/ggx_lobe_test).

// P, B, delta and gamma.
vec4 multum_ggx_lobe_shape(sampler2D table, float alpha, float d) {
  float s = sqrt(alpha * alpha + 2.0 * d);
  vec2 place = vec2(alpha / max(s, 1e-9), s * 0.577350269);
  return textureLod(table, (place * 31.0 + 0.5) / 32.0, 0.0);
}

float multum_ggx_lobe_density(vec4 shape, float alpha, float d, float e) {
  float square = alpha * alpha + 2.0 * d;
  float inverse_kappa = 1.0 / max(multum_vmf_kappa(d), 1e-6);
  float reach = sqrt(inverse_kappa * (4.7 + 3.0 * inverse_kappa));
  float u = clamp(0.5 + 0.5 * (1.0 - e) / max(reach, 1e-6), 0.0, 1.0);
  float y = shape.y * e * (1.0 - 0.5 * e / (1.0 + 5.0 * inverse_kappa)) / square;
  return shape.x / (MULTUM_PI * square) * u * u * (3.0 - 2.0 * u) * pow(1.0 + y * (1.0 + shape.z * y), -shape.w);
}

// The concentration about h that GGX's facets have where the lobe's normals reflect: what stands for the facets'
// kappa in the highlight's cosine. GGX is a mixture of normal distributions, and 4 / (alpha^2 + x^2) is the mixture's
// mean precision at the distance x from its middle: x^2 is that of the normals' mean direction from h, plus what they
// scatter about it. Less for rough facets, which end at the horizon. Two steps from the peak's; e = 1 - mu.h.
float multum_ggx_facet_kappa(float alpha, float kappa, float e) {
  float x = alpha * alpha;
  float facets = 2.0 / x;
  for (int step = 0; step < 2; ++step) {
    float sum = facets + kappa;
    float size = sqrt(max(sum * sum - 2.0 * facets * kappa * e, 1e-12));  // |facets h + kappa mu|
    float beside = 2.0 * kappa * e * (size + kappa - facets) / (size * (size + sum));
    facets = 4.0 / ((1.0 + 0.5 * alpha) * (x + beside + 3.0 / sum));
  }
  return facets;
}

// GGX of alpha convolved with the lobe at the unit half vector h, per solid angle, amplitude included.
float multum_movmf_ggx(sampler2D table, vec4 lobe, vec3 h, float alpha) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float d = multum_movmf_spread(lobe);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return lobe.w * multum_ggx_lobe_density(multum_ggx_lobe_shape(table, alpha, d), alpha, d, e);
}

// What facet_kappa of multum_movmf_highlight_cosine() is for GGX over the lobe.
float multum_movmf_ggx_facet_kappa(vec4 lobe, vec3 h, float alpha) {
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return multum_ggx_facet_kappa(alpha, multum_vmf_kappa(multum_movmf_spread(lobe)), e);
}

// The specular part of glTF's material over the lobe, D V max(n . l, 0), without Fresnel's term (multum_schlick): what
// a light of irradiance 1 gives. Add it up over the lobes. l, v, h: unit, tangent space; alpha: roughness^2.
float multum_movmf_ggx_specular(sampler2D table, vec4 lobe, vec3 l, vec3 v, vec3 h, float alpha) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float d = multum_movmf_spread(lobe);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  vec4 normals = multum_movmf_reflecting_normals(lobe, h, multum_ggx_facet_kappa(alpha, multum_vmf_kappa(d), e));
  float n_l = multum_vmf_mean_cosine(normals.w, dot(normals.xyz, l));
  float n_v = multum_vmf_mean_cosine(normals.w, dot(normals.xyz, v));
  float facets = lobe.w * multum_ggx_lobe_density(multum_ggx_lobe_shape(table, alpha, d), alpha, d, e);
  return facets * n_l * multum_smith_visibility(alpha, n_l, n_v);
}

#ifdef MULTUM_GGX
uniform sampler2D u_ggx_lobe_table;

vec3 multum_lobe_facets(vec4 lobe, vec3 h) {
  return vec3(multum_movmf_ggx(u_ggx_lobe_table, lobe, h, multum_alpha));
}

vec3 multum_lobe_highlight(vec4 lobe, vec3 h, vec3 l) {
  float facet_kappa = multum_movmf_ggx_facet_kappa(lobe, h, multum_alpha);
  return multum_lobe_facets(lobe, h) * multum_movmf_highlight_cosine(lobe, h, l, facet_kappa);
}
#endif
