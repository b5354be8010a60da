// SPDX-License-Identifier: Apache-2.0
// Shades filtered moments: Toksvig's rule (Toksvig 2005) with the mean normal, and LEAN (Olano and Baker 2010) with the
// moments of slopes. Paste this file after movmf_shading.glsl and brdf/blinn_phong.glsl. Hardware filters the textures
// of a baked file of moments (docs/reference/file_format.md, "Moments"):
//
//     vec4 mean = texture(mean_map, uv);       // E[n], E[b_s b_t]
//     vec4 slopes = texture(slope_map, uv);    // E[b_s], E[b_t], E[b_s^2], E[b_t^2]; b = -(n_x, n_y) / n_z
//     float facets = multum_moments_lean(slopes, mean.w, h, s, true);      // or multum_moments_toksvig(mean.xyz, h, s)
//     radiance += albedo / pi * max(dot(mean.xyz, l), 0.0) + k_s * facets * max(dot(normalize(mean.xyz), l), 0.0);
//
// Lambert of the mean, max(E[n] . l, 0), is exact if no normal faces away from the light.

// Returns Blinn-Phong whose exponent s is reduced to g s by the mean normal's length L, where g = L / (L + s (1 - L)).
float multum_moments_toksvig(vec3 mean_normal, vec3 h, float s) {
  float size = length(mean_normal);
  if (size <= 1e-12) return 0.0;
  float gloss = size / (size + s * max(1.0 - size, 0.0));
  return multum_blinn_phong(gloss * s, multum_one_minus_cosine(mean_normal / size, h));
}

// Returns the density of slopes at the slope of h. The density is a Gaussian whose covariance is that of the slopes
// plus 1/s, which is the variance of Blinn-Phong with exponent s. The Jacobian 1 / cos^3 converts this density to a
// density per solid angle, as Blinn-Phong is. Rounding can give variances below 0 and correlations above 1, which are
// set to these limits.
float multum_moments_lean(vec4 slopes, float cross_moment, vec3 h, float s, bool with_jacobian) {
  if (h.z <= 1e-4) return 0.0;
  float base = 1.0 / s;
  vec2 variance = max(slopes.zw - slopes.xy * slopes.xy, vec2(0.0));
  float limit = sqrt(variance.x * variance.y);
  float covariance = clamp(cross_moment - slopes.x * slopes.y, -limit, limit);
  // The determinant of Sigma + I/s. The terms of det Sigma cancel, but this does little harm, because det Sigma is only
  // a part of the sum.
  float determinant = base * (base + variance.x + variance.y) +
                      max(variance.x * variance.y - covariance * covariance, 0.0);
  vec2 b = -h.xy / h.z - slopes.xy;
  float distance = (dot((variance.yx + vec2(base)) * b, b) - 2.0 * covariance * b.x * b.y) / determinant;
  float density = exp(-0.5 * max(distance, 0.0)) / (2.0 * MULTUM_PI * sqrt(determinant));
  return with_jacobian ? density / (h.z * h.z * h.z) : density;
}
