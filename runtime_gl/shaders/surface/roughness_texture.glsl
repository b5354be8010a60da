// SPDX-License-Identifier: Apache-2.0
// Reads GGX's roughness from a texture and multiplies it by the BRDF's own roughness, as in glTF 2.0. References read
// it for each finest texel (normals.glsl). Otherwise the perceptual roughness is averaged over the footprint.
uniform sampler2D u_roughness_texture;  // roughness in the red channel

const float MULTUM_ALPHA_MIN = 0.0025;

MultumFootprint multum_roughness_footprint(vec2 st) { return multum_footprint(u_roughness_texture, st); }

// `footprint` is the result of multum_roughness_footprint(), or one of its taps.
void multum_take_roughness(vec2 st, MultumFootprint footprint) {
#if defined(MULTUM_DRAWN_TEXEL)
  ivec2 texel = multum_footprint_texel(u_normals, st, multum_surface_footprint(st));
  float roughness = texel == MULTUM_NO_TEXEL ? 1.0 : texelFetch(u_roughness_texture, texel, 0).r;
#elif defined(MULTUM_REFERENCE)
  float roughness = textureLod(u_roughness_texture, st, 0.0).r;
#else
  float roughness = multum_filtered(u_roughness_texture, st, footprint).r;
#endif
  multum_alpha = max(u_alpha * roughness * roughness, MULTUM_ALPHA_MIN);
}
