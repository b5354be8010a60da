// SPDX-License-Identifier: Apache-2.0
// Computes the highlight of a lobe under an environment by harmonics of the half vector (Han et al. 2007, section 8).
// The highlight is the sum over l and m of a_l(f) a_l(vMF) L'_lm Y_lm(mu). L' = 4 (v.h) (v.h) L(reflect(v, h)) depends
// on the view. The coefficients of L' are in a texture over the picture, with one plane per (l, m), computed for the
// frame's camera. The cosine and other factors that depend on the normal are computed as a quotient, which is the
// reflection table's weight divided by the weight of 4 (v.h) (v.h).
#define MULTUM_HALF_COUNT 81.0
uniform sampler2D u_half_vector_light;
uniform vec2 u_half_grid;  // columns and rows of a plane
uniform vec2 u_viewport;   // in pixels
uniform vec3 u_half_zonal[MULTUM_VMF_ZONAL_ORDER + 1];  // a_l of the BRDF's facets

vec3 multum_half_vector_light(int index) {
  vec2 position = vec2(0.5) + gl_FragCoord.xy / u_viewport * (u_half_grid - 1.0);
  position.y += float(index) * u_half_grid.y;
  return textureLod(u_half_vector_light, position / (u_half_grid * vec2(1.0, MULTUM_HALF_COUNT)), 0.0).rgb;
}

// Returns the share of the light that the cosine and the other factors keep, for a lobe.
vec3 multum_reflection_quotient(vec3 mu, float d, vec3 v) {
  vec3 weight = vec3(0.0);
  float plain = 0.0;
  for (int i = 0; i < MULTUM_ENVIRONMENT_TERMS; ++i) {
    vec4 entry = multum_reflection_entry(i, dot(mu, v), d);
    weight += entry.rgb;
    plain += entry.w;
  }
  return weight / max(plain, 1e-6);
}

vec3 multum_environment_specular(vec3 mu, float d, vec3 v) {
  float zonal[MULTUM_VMF_ZONAL_ORDER + 1];
  multum_vmf_zonal(multum_vmf_kappa(d), zonal);
  vec3 m = multum_environment_frame * mu;
  vec3 sum = vec3(0.0);
  float cosine = 1.0, sine = 0.0;                   // sin^m theta (cos, sin)(m phi)
  float diagonal = 0.5 * inversesqrt(MULTUM_PI);    // K_mm P_mm / sin^m theta
  for (int order = 0; order <= MULTUM_VMF_ZONAL_ORDER; ++order) {
    float k = float(order);
    if (order > 0) {
      float next = m.x * cosine - m.y * sine;
      sine = m.x * sine + m.y * cosine;
      cosine = next;
      diagonal *= sqrt((2.0 * k + 1.0) / (2.0 * k));
    }
    float before = 0.0, p = diagonal;
    for (int l = order; l <= MULTUM_VMF_ZONAL_ORDER; ++l) {
      float f = float(l), g = f - 1.0;
      if (l > order) {
        float a = sqrt((4.0 * f * f - 1.0) / (f * f - k * k));
        float next = a * (m.z * p - sqrt(max(g * g - k * k, 0.0) / (4.0 * g * g - 1.0)) * before);
        before = p;
        p = next;
      }
      int index = l * (l + 1);
      vec3 light = multum_half_vector_light(index + order) * cosine;
      if (order > 0) light = sqrt(2.0) * (light + multum_half_vector_light(index - order) * sine);
      sum += u_half_zonal[l] * zonal[l] * p * light;
    }
  }
  return max(sum, vec3(0.0)) * multum_reflection_quotient(mu, d, v);
}
