// SPDX-License-Identifier: Apache-2.0
// Shades a mixture of MULTUM_LOBE_COUNT planar Gaussians (Tan et al. 2005, section 3), after common/gmm_shading.glsl.
// lobes.glsl fetches the Gaussians, and Tan's BRDF shades them. From the scene's BRDF, only its width, u_exponent, is
// used, and its shadowing with MULTUM_VISIBILITY. The formula is I = k_s F sum a_i g(h; mu_i, sigma_i) V max(mu_i . l,
// 0) + k_d (1 - F) sum a_i max(mu_i . l, 0). With V = 1 / (4 mu.l mu.v) this is the paper's formula.

// Returns V at the mean of the normals that reflect towards v. These normals are the lobe's Gaussian times that of the
// facets around h.
float multum_gmm_visibility(vec4 lobe, float n_l, vec3 v, vec3 h) {
#ifdef MULTUM_VISIBILITY
  float facets = multum_gmm_facet_variance(lobe, u_exponent);
  float share = facets / max(facets + multum_gmm_variance(lobe), MULTUM_GMM_VARIANCE_MIN);
  vec3 n = multum_gmm_lifted(mix(h.xy, multum_gmm_mean(lobe), share));
  float n_v = max(dot(multum_gmm_lifted(multum_gmm_mean(lobe)), v), 0.0);
  return multum_visibility(n_l, n_v, max(dot(n, h), 0.0), max(dot(v, h), 0.0));
#else
  return 1.0;
#endif
}

MultumReflection multum_reflect(MultumSurface surface, vec3 l, vec3 v, vec3 h) {
  MultumReflection sum = MultumReflection(vec3(0.0), vec3(0.0));
  MULTUM_EACH_PART(j) {
    vec4 lobe = surface.lobes[j];
#ifdef MULTUM_NORMAL_MAP
    if (j == MULTUM_LOBE_COUNT) lobe = multum_gmm_normal_map(lobe);
#endif
    float diffuse = multum_gmm_lambert(lobe, l);
    float cosine = diffuse / max(lobe.w, MULTUM_AMPLITUDE_MIN);
    sum.diffuse += MULTUM_TINTED(surface, j, vec3(diffuse));
#ifndef MULTUM_LAMBERT
    sum.specular += vec3(multum_gmm_density(lobe, h, u_exponent) * cosine * multum_gmm_visibility(lobe, cosine, v, h));
#endif
  }
  return sum;
}
