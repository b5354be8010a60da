// SPDX-License-Identifier: Apache-2.0
// Computes the zonal coefficients of a vMF, where a_l is the integral over the sphere of its density times P_l.
// Convolution with the vMF multiplies the harmonics of order l by a_l (after movmf_shading.glsl).
#ifndef MULTUM_VMF_ZONAL_ORDER
#define MULTUM_VMF_ZONAL_ORDER 8
#endif

// Returns a_2 = 1 - 3 |r| / kappa, or 3/5 r^2 near r = 0, where this difference loses precision.
float multum_vmf_second_zonal(float r, float kappa) { return r > 0.1 ? 1.0 - 3.0 * r / kappa : 0.6 * r * r; }

// Computes a_l = a_(l-1) R_l, R_l = 1 / ((2 l + 1) / kappa + R_(l+1)), downwards from the asymptotic quotient twelve
// orders above.
void multum_vmf_zonal(float kappa, out float zonal[MULTUM_VMF_ZONAL_ORDER + 1]) {
  const int above = MULTUM_VMF_ZONAL_ORDER + 12;
  float middle = float(above) + 0.5;
  float quotient = kappa / (middle + sqrt(middle * middle + kappa * kappa));
  float quotients[MULTUM_VMF_ZONAL_ORDER + 1];
  for (int l = above - 1; l >= 1; --l) {
    quotient = kappa / (float(2 * l + 1) + kappa * quotient);
    if (l <= MULTUM_VMF_ZONAL_ORDER) quotients[l] = quotient;
  }
  zonal[0] = 1.0;
  for (int l = 1; l <= MULTUM_VMF_ZONAL_ORDER; ++l) zonal[l] = zonal[l - 1] * quotients[l];
}
