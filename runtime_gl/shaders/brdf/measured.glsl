// SPDX-License-Identifier: Apache-2.0
// Computes a measured BRDF for one normal as a product of the two factors f(theta_h) and g(theta_d), which are tables
// of host/formats/brdf/measured_brdf.h. For lobes, terms.glsl sums vMFs instead.
#ifdef MULTUM_MEASURED
#define MULTUM_FACET_TABLE_SIZE 90
#define MULTUM_DIFFERENCE_TABLE_SIZE 19
uniform vec3 u_facets[MULTUM_FACET_TABLE_SIZE];            // theta_h = (pi / 2) (i / (size - 1))^2
uniform float u_differences[MULTUM_DIFFERENCE_TABLE_SIZE];  // theta_d = (pi / 2) i / (size - 1)

vec3 multum_facets(vec3 n, vec3 h) {
  float e = multum_one_minus_cosine(n, h);
  if (e >= 1.0) return vec3(0.0);
  float theta = 2.0 * asin(sqrt(0.5 * e));
  float x = sqrt(theta / (0.5 * MULTUM_PI)) * float(MULTUM_FACET_TABLE_SIZE - 1);
  int i = clamp(int(x), 0, MULTUM_FACET_TABLE_SIZE - 2);
  return mix(u_facets[i], u_facets[i + 1], min(x - float(i), 1.0));
}

#ifdef MULTUM_FRESNEL
vec3 multum_fresnel(float v_h) {
  float x = acos(clamp(v_h, 0.0, 1.0)) / (0.5 * MULTUM_PI) * float(MULTUM_DIFFERENCE_TABLE_SIZE - 1);
  int i = clamp(int(x), 0, MULTUM_DIFFERENCE_TABLE_SIZE - 2);
  return vec3(mix(u_differences[i], u_differences[i + 1], min(x - float(i), 1.0)));
}
#endif
#endif
