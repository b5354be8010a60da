// SPDX-License-Identifier: Apache-2.0
// Shades one lobe of a filtered mixture of von Mises-Fisher (vMF) lobes: Han et al. 2007, sections 4 and 7. Paste this
// file, followed by the files of brdf/ that you need, into any GLSL 330 or ES 300 shader (`precision highp float;`
// there). Without flags these files have no uniforms, samplers or outputs. A texel holds, per lobe, (a r_x, a r_y, a
// r_z, a): amplitude a, and mean vector r of the lobe's normals in tangent space. Let the hardware filter it, call a
// function for every lobe, and add the results:
//
//     vec4 lobe = texture(lobe_map, uv);
//     float facets = multum_movmf_blinn_phong(lobe, h, s);          // l, h: unit, tangent space
//     float cosine = multum_movmf_highlight_cosine(lobe, h, l, multum_vmf_kappa(1.0 / (s + 2.0)));
//     radiance += albedo / pi * multum_movmf_lambert(lobe, l) + k_s * facets * cosine;
//
// A file that leaves the finest levels to the normal map (multum:firstLevel > 0) has one more lobe: see
// multum_normal_map_share() at the end.
//
// Every function returns a * integral f(n . w) vMF(n) dn, the spherical convolution of the BRDF's one-angle factor f
// with the lobe, times the amplitude. For a lobe of amplitude 0 (no material, or a lobe that does not occur here), the
// result is 0. The highlight's own cosine max(n . l, 0) also depends on n. multum_movmf_highlight_cosine() returns its
// mean over f(n . h) vMF(n). docs/contributing/ALGORITHMS.md, "The highlight's cosine", compares it with other methods.

const float MULTUM_PI = 3.14159265358979;
const float MULTUM_AMPLITUDE_MIN = 1e-6;  // smaller counts as 0; 1/32767, the least stored amplitude, is 30
                                          // times this

// Returns 1 - |r|, the lobe's spread, which is 0 for one direction and 1 for all directions. It is computed as (a - |a
// r|) / a. Rounding of stored values can make |r| slightly larger than 1, which counts as 1.
float multum_movmf_spread(vec4 lobe) {
  return max(lobe.w - length(lobe.xyz), 0.0) / max(lobe.w, MULTUM_AMPLITUDE_MIN);
}

// Returns the mean direction mu. For r = 0 the result may be any unit vector, because no other value then depends on
// it.
vec3 multum_movmf_mean_direction(vec4 lobe) {
  float size = length(lobe.xyz);
  return size > 1e-12 ? lobe.xyz / size : vec3(0.0, 0.0, 1.0);
}

// Returns 1 - mu . w = |mu - w|^2 / 2 for unit vectors, without cancellation for dot products close to 1.
float multum_one_minus_cosine(vec3 mu, vec3 w) {
  vec3 difference = mu - w;
  return 0.5 * dot(difference, difference);
}

// Returns kappa for q = 1 - A, where A = coth kappa - 1/kappa is the mean cosine of a vMF. Uses Banerjee's formula
// kappa = A (3 - A^2) / (1 - A^2), with its factor 3 - A^2 refined by a polynomial that keeps both ends exact. The
// relative error is at most 2.3e-4, without branches or iterations. The code uses 1 - A^2 = q (2 - q).
float multum_vmf_kappa(float q) {
  float mean_cosine = 1.0 - q;
  float x = mean_cosine * mean_cosine;
  float p = -0.20753 + x * (-0.12665 + x * (-1.04417 + x * 0.90242));
  return mean_cosine * (3.0 - x + x * (1.0 - x) * p) / max(q * (2.0 - q), 1e-12);
}

// Returns the vMF density kappa / (4 pi sinh kappa) exp(kappa t), where e = 1 - t, in a form that neither overflows nor
// divides 0 by 0. For kappa near 0, exp(-2 kappa) is 1 - 2 kappa + ..., so the quotient is 1/2 there.
float multum_vmf_density(float kappa, float e) {
  float scale = kappa > 1e-3 ? kappa / (1.0 - exp(-2.0 * kappa)) : 0.5 * (1.0 + kappa);
  return scale / (2.0 * MULTUM_PI) * exp(-kappa * e);
}

// Returns 1 - A(kappa) = 1/kappa - 2 / (exp(2 kappa) - 1), or the first terms of its series where this difference loses
// precision.
float multum_vmf_spread(float kappa) {
  if (kappa < 0.1) return 1.0 - kappa * (1.0 / 3.0 - kappa * kappa / 45.0);
  return 1.0 / kappa - 2.0 / (exp(min(2.0 * kappa, 80.0)) - 1.0);
}

// Returns the lobe without a BRDF's width, for diffuse light, which does not depend on roughness. If lobes contain a
// BRDF's width (multum:roughness), this width has shortened their mean vectors by a factor. Only the factor's mean over
// the map is known (multum:meanCosine).
vec4 multum_movmf_without_roughness(vec4 lobe, float mean_cosine) {
  return vec4(lobe.xyz * min(1.0 / mean_cosine, lobe.w / max(length(lobe.xyz), 1e-12)), lobe.w);
}

// Returns the mean of max(n . l, 0) over a vMF of spread d = 1 - |r|, where t is the cosine between its mean direction
// and l. With m = |r| t and x = n . l, E max(x, 0) is (m + E|x|) / 2. E|x| is modelled as sqrt(m^2 + v exp(-g)), which
// is the shape of the mean of a folded normal distribution, where v = (E|x|)^2 at t = 0 and g is a polynomial in m^2 /
// v. The relative L1 error over the sphere of l is at most 0.22 % (spherical harmonics to l = 2 have 2-3 %). The result
// is exact at |r| = 1, where it is max(t, 0), and at r = 0, where it is 1/4.
float multum_vmf_mean_cosine(float d, float t) {
  float r = 1.0 - d;
  float m = r * t;
  float v = d * (0.25 + r * (0.2343 + r * 0.15232));
  float x = min(m * m / max(v, 1e-20), 200.0);
  float g = x * (0.4117 + r * (0.2857 - r * 0.3658) + 0.0080 * x);
  return 0.5 * (m + sqrt(m * m + v * exp(-g)));
}

// Returns Lambert, max(n . l, 0), convolved with the lobe. The caller multiplies by albedo / pi.
float multum_movmf_lambert(vec4 lobe, vec3 l) {
  if (lobe.w <= MULTUM_AMPLITUDE_MIN) return 0.0;
  return lobe.w * multum_vmf_mean_cosine(multum_movmf_spread(lobe), dot(multum_movmf_mean_direction(lobe), l));
}

// Returns the normals of the lobe that reflect from l to the eye. Their distribution is f(n . h) vMF(n). If f is a vMF
// about h with concentration facet_kappa, their distribution is also a vMF. The vector facet_kappa h + kappa mu has the
// direction of this vMF, and its length is the concentration. Returns the mean direction in xyz and the spread in w.
vec4 multum_movmf_reflecting_normals(vec4 lobe, vec3 h, float facet_kappa) {
  float d = multum_movmf_spread(lobe);
  vec3 sum = facet_kappa * h + multum_vmf_kappa(d) * multum_movmf_mean_direction(lobe);
  float size = length(sum);
  return vec4(sum / max(size, 1e-6), d > 0.0 ? multum_vmf_spread(size) : 0.0);  // a lobe of one direction reflects with
                                                                                // that normal
}

// Returns the highlight's cosine, which is the mean of max(n . l, 0) over the normals of
// multum_movmf_reflecting_normals(). If f convolved with the lobe is multiplied by this cosine, the product is the
// integral of f(n . h) max(n . l, 0). For vMFs, the only error of the integral is the 0.22 % above. Blinn-Phong is
// replaced by the vMF with the same mean cosine. The relative L1 error over l and the eye is then at most 5.5 % for s =
// 1, 1.2 % for s >= 5 and 0.25 % for s >= 20.
float multum_movmf_highlight_cosine(vec4 lobe, vec3 h, vec3 l, float facet_kappa) {
  vec4 normals = multum_movmf_reflecting_normals(lobe, h, facet_kappa);
  return multum_vmf_mean_cosine(normals.w, dot(normals.xyz, l));
}

// Returns a normal drawn from the lobe's vMF, where `xi` is uniform in the unit square. The function is for renderers
// that keep one normal per pixel, such as deferred renderers. Choose a lobe with its amplitude as probability, draw the
// normal here, and shade it with the material's own roughness. The mean over many frames equals the sum over lobes. 1 -
// cosine is computed by inversion (Ulrich 1984), and tangents as in Duff et al. 2017.
vec3 multum_movmf_drawn_normal(vec4 lobe, vec2 xi) {
  vec3 mu = multum_movmf_mean_direction(lobe);
  float kappa = max(multum_vmf_kappa(multum_movmf_spread(lobe)), 1e-3);
  float e = clamp(-log(max(1.0 - xi.x * (1.0 - exp(-2.0 * kappa)), 1e-30)) / kappa, 0.0, 2.0);
  float across = sqrt(e * (2.0 - e));
  float side = mu.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (side + mu.z);
  float b = mu.x * mu.y * a;
  vec3 s = vec3(1.0 + side * mu.x * mu.x * a, side * b, -side * mu.x);
  vec3 t = vec3(b, side + mu.y * mu.y * a, -mu.y);
  float phi = 2.0 * MULTUM_PI * xi.y;
  return (1.0 - e) * mu + across * (cos(phi) * s + sin(phi) * t);
}

// Returns the mean of a normal map's normals for a pixel that is smaller than a texel, or slightly larger. Between
// texels, the filter's mean is as short as if the pixel covered all four texels. If normals turn by g per texel, the
// length of the mean decreases by g^2 / 6 on average. The normals under a pixel that is w texels wide have a variance
// of g^2 w^2 / 12. This is w^2 / 2 times the loss of length. For w^2 >= 2, where coarser levels are used, the whole
// loss counts. `map_lod` is log2 w, where w is the pixel's longer side. `lobe` is (a r, a), where a is less than 1 only
// at a black border. Do not use this function for files with roughness in their lobes (multum:roughness), because the
// lengths of these lobes also contain the BRDF's width.
vec4 multum_movmf_magnified(vec4 lobe, float map_lod) {
  float size = length(lobe.xyz);
  if (size <= MULTUM_AMPLITUDE_MIN) return lobe;
  float seen = exp2(2.0 * min(map_lod, 0.5) - 1.0);
  return vec4(lobe.xyz * (mix(lobe.w, size, seen) / size), lobe.w);
}

// Returns the share of the normal map, which is one more lobe in files whose finest stored level L = multum:firstLevel
// is not 0. The lobe maps begin at L; the levels finer than L come from the normal map. The mips of the normal map must
// be averages of unit vectors, and must not be normalised. Use a float or snorm texture with x, y and z, or an unsigned
// one that is decoded after filtering. The length of an average gives the lobe's spread, as in Toksvig's rule; at level
// 0 the length is 1.
//
//     float lod = textureQueryLod(lobe_map[0], uv).y;               // ES 300: EXT_texture_query_lod or derivatives
//     float share = multum_normal_map_share(lod);
//     vec4 lobe = share * multum_movmf_magnified(vec4(texture(normal_map, uv).xyz, 1.0), lod + L);   // shade it, and
//     vec4 lobe_J = (1.0 - share) * texture(lobe_map[J], uv);                                        // for every J it
//
// `lod` is the level of detail of the lobe maps before clamping: 0 at L, -1 at L - 1. The normal map's share is 0 from
// L on, 1 up to L - 1, and linear in between, as in trilinear filtering. All functions above are linear in (a r, a), so
// a lobe that is multiplied by a share gives the same share of the light. The normal map's own level of detail must
// stop at L - 1 (GL_TEXTURE_MAX_LEVEL, or textureLod), because lobes replace its coarser levels. This lobe's colour
// comes from the albedo map. With an anisotropic sampler, `lod` is for the pixel's shorter side.
// multum_movmf_magnified() needs the longer side: the larger of dFdx and dFdy of uv times the map's size.
float multum_normal_map_share(float lod) { return clamp(-lod, 0.0, 1.0); }
