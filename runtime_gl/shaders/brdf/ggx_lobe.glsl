// SPDX-License-Identifier: Apache-2.0
// Computes GGX convolved with a vMF lobe as one term, for any roughness, even from a texture (after movmf_shading.glsl
// and ggx.glsl). host/formats/brdf/ggx_lobe.h has the formula and computes the table: 32 x 32 RGBA16F, linear filter,
// clamped.
//
//     specular = multum_movmf_ggx_specular(ggx_lobe_table, lobe, l, v, h, alpha);
//
// For many lights, compute the lobe's own part once with multum_ggx_lobe_facets(), and the rest for each light with
// multum_ggx_lobe_specular().
//
// Over all roughnesses and lobes, its relative L1 error against the exact convolution, over the sphere of h, is at most
// 4.5 % (tests/gl/ggx_lobe_test).

// Returns P / pi, B, delta and -gamma of host/formats/brdf/ggx_lobe.h. The factors 31 / 32, and 31 / 32 over sqrt(3),
// map to texel centres.
vec4 multum_ggx_lobe_shape(sampler2D table, float alpha, float d) {
  float s = sqrt(alpha * alpha + 2.0 * d);
  return textureLod(table, vec2(alpha / s, s) * vec2(0.96875, 0.5593080732) + 0.015625, 0.0);
}

// Returns approximately 1 / kappa of a lobe of spread d. The value is precise enough for widths, and finite at d = 1.
float multum_vmf_scatter(float d) { return d / (1.001 - d); }

// Returns the density of facets whose P and B are divided by s^2.
float multum_ggx_lobe_curve(vec4 facets, float alpha, float d, float e) {
  float reach = sqrt(4.5 * multum_vmf_scatter(d) + 1e-12);
  float bend = -0.5 * (alpha * alpha) * (1.0 / (alpha * alpha + 2.0 * d));
  float y = facets.y * e * (1.0 + bend * e);
  return facets.x * smoothstep(-reach, reach, 1.0 - e) * pow(1.0 + y * (1.0 + facets.z * y), facets.w);
}

float multum_ggx_lobe_density(vec4 shape, float alpha, float d, float e) {
  float scale = 1.0 / (alpha * alpha + 2.0 * d);
  return multum_ggx_lobe_curve(vec4(shape.x * scale, shape.y * scale, shape.z, shape.w), alpha, d, e);
}

// Returns the concentration of GGX's facets about h at the lobe's reflecting normals. The highlight's cosine uses it as
// the facets' kappa. GGX is a mixture of normal distributions, and 4 / (alpha^2 + x^2) is the mixture's mean precision
// at distance x from its middle. x^2 is the squared distance of the normals' mean direction from h, plus the normals'
// scatter about this direction. For rough facets the scatter is smaller, because they end at the horizon. The function
// starts from the peak's value and iterates twice. e is 1 - mu.h.
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

// Returns GGX with the given alpha, convolved with the lobe at the unit half vector h. The result is per solid angle
// and multiplied by the amplitude.
float multum_movmf_ggx(sampler2D table, vec4 lobe, vec3 h, float alpha) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  float d = multum_movmf_spread(lobe);
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return lobe.w * multum_ggx_lobe_density(multum_ggx_lobe_shape(table, alpha, d), alpha, d, e);
}

// Returns the facet_kappa of multum_movmf_highlight_cosine() for GGX convolved with the lobe.
float multum_movmf_ggx_facet_kappa(vec4 lobe, vec3 h, float alpha) {
  float e = multum_one_minus_cosine(multum_movmf_mean_direction(lobe), h);
  return multum_ggx_facet_kappa(alpha, multum_vmf_kappa(multum_movmf_spread(lobe)), e);
}

// Returns the part that depends only on the lobe and the roughness, for multum_ggx_lobe_specular(). Compute it once per
// lobe.
vec4 multum_ggx_lobe_facets(sampler2D table, vec4 lobe, float alpha) {
  float d = multum_movmf_spread(lobe);
  float scale = 1.0 / (alpha * alpha + 2.0 * d);
  vec4 shape = multum_ggx_lobe_shape(table, alpha, d);
  return vec4(lobe.w * (shape.x * scale), shape.y * scale, shape.z, shape.w);
}

// Returns the specular part of glTF's material convolved with the lobe, D V max(n . l, 0), without Fresnel's term
// (multum_schlick), for a light of irradiance 1. l, v and h are unit vectors in tangent space. alpha is roughness^2,
// above 0. `mu` and `d` are the lobe's mean direction and spread.
//
// The normals that reflect from l to v are facets about h times the lobe about mu. Facets and lobe are treated as
// Gaussians with the variances 0.6 alpha^2 + 0.1 e and 1 / kappa. The mean of their product is `sum`, its spread y is
// `both / |sum|`, and q = y / (1 + y) replaces the spread of a vMF. The mean of max(n . l, 0) is (m + sqrt(m^2 + 0.15
// q)) / 2, where m is the mean normal's cosine. The constants are fitted to the whole highlight
// (tests/gl/ggx_lobe_test). Smith's V, which is computed from two mean cosines, causes a larger error than these
// constants. A lobe without width gives the result for one normal. The code uses doubled cosines until the end.
float multum_ggx_lobe_specular(vec4 facets, vec3 mu, float d, vec3 l, vec3 v, vec3 h, float alpha) {
  float x = alpha * alpha;
  float e = multum_one_minus_cosine(mu, h);
  float of_lobe = multum_vmf_scatter(d);
  float of_facets = 0.6 * x + 0.1 * e;
  vec3 sum = of_lobe * h + of_facets * mu;
  float both = of_lobe * of_facets;
  float scale = 1.0 / (sqrt(dot(sum, sum)) + both);
  float m_l = scale * dot(sum, l);
  float m_v = scale * dot(sum, v);
  float variance = 0.15 * scale * both;
  float n_l = m_l + sqrt(m_l * m_l + variance);
  float n_v = m_v + sqrt(m_v * m_v + variance);
  float masking = n_l * sqrt(mix(n_v * n_v, 4.0, x));
  float shadowing = n_v * sqrt(mix(n_l * n_l, 4.0, x));
  return multum_ggx_lobe_curve(facets, alpha, d, e) * n_l / max(masking + shadowing, 1e-6);
}

// Returns the specular part of one lobe. The caller adds up the results of all lobes.
float multum_movmf_ggx_specular(sampler2D table, vec4 lobe, vec3 l, vec3 v, vec3 h, float alpha) {
  vec4 facets = multum_ggx_lobe_facets(table, lobe, alpha);
  return multum_ggx_lobe_specular(facets, multum_movmf_mean_direction(lobe), multum_movmf_spread(lobe), l, v, h, alpha);
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
