// SPDX-License-Identifier: Apache-2.0
// Fetches lobes by trilinear filtering. Contains the textures and MultumSurface of movmf.glsl and gmm.glsl, which
// follow this file. With MULTUM_COLOURS, lobes have colours. With MULTUM_MEAN_COLOURS, all lobes share the colour of a
// separate texture. With MULTUM_NORMAL_MAP, levels finer than those of the lobes come from the normal map, as one more
// lobe (a r, a) of a mean normal. With MULTUM_ALBEDO_MAP, this lobe has its own colours. With MULTUM_BASIS k,
// everything is multiplied by weight k of the lobes. With MULTUM_DRAWN_LOBE, a single normal is used, which is drawn at
// random from the lobes by amplitude for each of u_sample frames. The random numbers come from blue_noise.glsl or, with
// MULTUM_HASHED, from footprint.glsl, whose numbers are white noise over the picture. With MULTUM_SHADE_FIRST, the
// lobes of all eight texels are fetched with their weights, so that each texel is shaded before filtering. Lobes that
// are not aligned need this flag, which also shades taps one by one. With MULTUM_MAGNIFIED, the surface of an
// interpolated normal map is shown between texels of level 0, instead of interpolating the texels' light. With
// MULTUM_WHOLE, the amplitudes of a texel sum to 1, except for storage errors, and are rescaled to 1. With
// MULTUM_LOBE_LAYERS n, lobes have the format of multum export --lobes, with 1 or 2 layers of an array per lobe, whose
// four channels are converted to (a r, a) (docs/reference/lobe_textures.md, "Lobes for GPUs").
#ifdef MULTUM_LOBE_LAYERS
#define MULTUM_FIRST_LOBES u_lobe_layers
uniform sampler2DArray u_lobe_layers;
uniform float u_lobe_unpacking[MULTUM_LOBE_COUNT * 20];  // four columns and an offset, 4 values each
#else
#define MULTUM_FIRST_LOBES u_lobes[0]
uniform sampler2D u_lobes[MULTUM_LOBE_COUNT];
#endif
#ifdef MULTUM_COLOURS
uniform sampler2D u_colours[MULTUM_LOBE_COUNT];
#endif
#ifdef MULTUM_MEAN_COLOURS
uniform sampler2D u_mean_colours;
#endif
#if defined(MULTUM_SHADE_FIRST)
#define MULTUM_PART_COUNT (8 * MULTUM_LOBE_COUNT)
#elif defined(MULTUM_NORMAL_MAP)
#define MULTUM_PART_COUNT (MULTUM_LOBE_COUNT + 1)
uniform sampler2D u_normal_map;  // mean normals of levels finer than those of the lobes; w = 0 beyond a black border
#else
#define MULTUM_PART_COUNT MULTUM_LOBE_COUNT
#endif
#ifdef MULTUM_ALBEDO_MAP
uniform sampler2D u_albedo_map;
#endif
#ifdef MULTUM_BASIS
uniform sampler2D u_weights[MULTUM_LOBE_COUNT];
#endif

// A single lobe needs no loop.
#if MULTUM_LOBE_COUNT == 1
#define MULTUM_EACH_LOBE(j) const int j = 0;
#else
#define MULTUM_EACH_LOBE(j) for (int j = 0; j < MULTUM_LOBE_COUNT; ++j)
#endif
#ifdef MULTUM_EVALUATIONS
int multum_part_count = MULTUM_PART_COUNT;  // number of parts; 1 if all are added up
#endif
#if MULTUM_PART_COUNT == 1
#define MULTUM_EACH_PART(j) const int j = 0;
#else
#ifdef MULTUM_EVALUATIONS
#define MULTUM_EACH_PART(j) for (int j = 0; j < multum_part_count; ++j)
#else
#define MULTUM_EACH_PART(j) for (int j = 0; j < MULTUM_PART_COUNT; ++j)
#endif
#endif

struct MultumSurface {
  vec4 lobes[MULTUM_PART_COUNT];  // the normal map's lobe is last
#if defined(MULTUM_COLOURS)
  vec3 albedos[MULTUM_PART_COUNT];
#elif defined(MULTUM_MEAN_COLOURS)
  vec3 albedo;
#endif
};

// The light of part j times its colour, before the multiplication by the BRDF's diffuse reflectance.
#if defined(MULTUM_COLOURS)
#define MULTUM_TINTED(surface, j, light) ((surface).albedos[j] * (light))
#elif defined(MULTUM_MEAN_COLOURS)
#define MULTUM_TINTED(surface, j, light) ((surface).albedo * (light))
#else
#define MULTUM_TINTED(surface, j, light) (light)
#endif

#if MULTUM_PART_COUNT > 1
// Returns the two of the first `count` parts that lose the least length when they are added. These are the most similar
// or the faintest parts.
ivec2 multum_alike_parts(vec4 lobes[MULTUM_PART_COUNT], int count) {
  ivec2 alike = ivec2(0, 1);
  float least = 1e30;
  for (int i = 0; i < count - 1; ++i)
    for (int j = i + 1; j < count; ++j) {
      float lost = length(lobes[i].xyz) + length(lobes[j].xyz) - length(lobes[i].xyz + lobes[j].xyz);
      if (lost < least) {
        least = lost;
        alike = ivec2(i, j);
      }
    }
  return alike;
}
#endif

MultumFootprint multum_surface_footprint(vec2 st) { return multum_footprint(MULTUM_FIRST_LOBES, st); }

ivec2 multum_lobe_map_size() { return textureSize(MULTUM_FIRST_LOBES, 0).xy; }
ivec2 multum_surface_size() { return multum_lobe_map_size(); }

#ifdef MULTUM_LOBE_LAYERS
vec4 multum_unpacking(int at) {
  return vec4(u_lobe_unpacking[at], u_lobe_unpacking[at + 1], u_lobe_unpacking[at + 2], u_lobe_unpacking[at + 3]);
}

// Unpacking is affine, so filtered channels unpack to the filtered lobe.
vec4 multum_fetch_lobe(int j, vec2 st, MultumFootprint footprint) {
#if MULTUM_LOBE_LAYERS == 1
  vec4 texel = multum_filtered(u_lobe_layers, st, float(j), footprint);
#else
  vec4 texel = vec4(multum_filtered(u_lobe_layers, st, float(2 * j), footprint).xy,
                    multum_filtered(u_lobe_layers, st, float(2 * j + 1), footprint).xy);
#endif
  vec4 lobe = multum_unpacking(20 * j + 16);
  for (int c = 0; c < 4; ++c) lobe += texel[c] * multum_unpacking(20 * j + 4 * c);
  return lobe;
}
#elif !defined(MULTUM_SHADE_FIRST)
vec4 multum_fetch_lobe(int j, vec2 st, MultumFootprint footprint) { return multum_filtered(u_lobes[j], st, footprint); }
#endif

#ifdef MULTUM_DRAWN_LOBE
#ifdef MULTUM_HASHED
vec3 multum_numbers_drawn() { return vec3(multum_random(0), multum_random(1), multum_random(2)); }
#else
uniform sampler2D u_blue_noise;

vec3 multum_numbers_drawn() { return multum_blue_noise(u_blue_noise, gl_FragCoord.xy, float(u_sample)); }
#endif

// Gives all amplitude to one normal, which is a lobe without width.
void multum_draw_lobe(inout MultumSurface surface) {
  float total = 0.0;
  {
    MULTUM_EACH_PART(j) total += surface.lobes[j].w;
  }
  vec3 numbers = multum_numbers_drawn();
  float left = numbers.x * total;
  int drawn = 0;
  for (; drawn < MULTUM_PART_COUNT - 1 && left >= surface.lobes[drawn].w; ++drawn) left -= surface.lobes[drawn].w;
  vec4 lobe = surface.lobes[drawn];
  vec3 normal = multum_movmf_drawn_normal(lobe, numbers.yz);
  {
    MULTUM_EACH_PART(j) surface.lobes[j] = j == drawn ? total * vec4(normal, 1.0) : vec4(0.0);
  }
}
#endif

#ifdef MULTUM_MAGNIFIED
// If a pixel is smaller than a texel, turns all lobes towards the mean normal there, so that their sum becomes
// multum_movmf_magnified() of the original sum.
void multum_magnify(inout MultumSurface surface, float lod) {
  if (lod >= 0.5) return;
  vec4 sum = vec4(0.0);
  {
    MULTUM_EACH_LOBE(j) sum += surface.lobes[j];
  }
  float size = length(sum.xyz);
  if (size <= MULTUM_AMPLITUDE_MIN) return;
  float seen = exp2(2.0 * lod - 1.0);
  {
    MULTUM_EACH_LOBE(j)
      surface.lobes[j].xyz = mix(surface.lobes[j].w / size * sum.xyz, surface.lobes[j].xyz, seen);
  }
}
#endif

#ifdef MULTUM_WHOLE
void multum_make_whole(inout MultumSurface surface) {
  float total = 0.0;
  {
    MULTUM_EACH_LOBE(j) total += surface.lobes[j].w;
  }
  {
    MULTUM_EACH_LOBE(j) surface.lobes[j] /= max(total, MULTUM_AMPLITUDE_MIN);
  }
}
#endif

#ifdef MULTUM_MEAN_COLOURS
vec3 multum_mean_colour(vec2 st, MultumFootprint footprint) {
  ivec2 from = multum_lobe_map_size(), to = textureSize(u_mean_colours, 0);
  return multum_filtered(u_mean_colours, st, multum_footprint_on(footprint, from, to)).rgb;
}
#endif

#ifdef MULTUM_SHADE_FIRST
#ifndef MULTUM_SHADE_TAPS
#define MULTUM_SHADE_TAPS
#endif
MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  MultumSurface surface;
#ifdef MULTUM_MEAN_COLOURS
  surface.albedo = multum_mean_colour(st, footprint);
#endif
  ivec2 size = textureSize(u_lobes[0], 0);
  int level_max = textureQueryLevels(u_lobes[0]) - 1;
  float lod = clamp(footprint.level, 0.0, float(level_max));
  for (int k = 0; k < 8; ++k) {  // k = 4 coarser + 2 below + right
    int level = min(int(lod) + (k >> 2), level_max);
    vec2 level_size = vec2(max(size >> level, ivec2(1)));
    vec2 place = st * level_size - 0.5;
    vec2 corner = vec2(k & 1, (k >> 1) & 1);
    vec2 weights = mix(1.0 - fract(place), fract(place), corner);
    float weight = weights.x * weights.y * (k < 4 ? 1.0 - fract(lod) : fract(lod));
    vec2 middle = (floor(place) + corner + 0.5) / level_size;  // the texel's middle, where no other texel is mixed in
    MULTUM_EACH_LOBE(j) {
      vec4 lobe = textureLod(u_lobes[j], middle, float(level));
#ifdef MULTUM_COLOURS
      vec3 colour = textureLod(u_colours[j], middle, float(level)).rgb;
      surface.albedos[k * MULTUM_LOBE_COUNT + j] = colour / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
#ifdef MULTUM_BASIS
      float share = textureLod(u_weights[j], middle, float(level))[MULTUM_BASIS];
      lobe *= share / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
      surface.lobes[k * MULTUM_LOBE_COUNT + j] = weight * lobe;
    }
  }
  return surface;
}
#else
MultumSurface multum_fetch_surface(vec2 st, MultumFootprint footprint) {
  MultumSurface surface;
#ifdef MULTUM_MEAN_COLOURS
  surface.albedo = multum_mean_colour(st, footprint);
#endif
#ifdef MULTUM_NORMAL_MAP
  MultumFootprint on_map = multum_footprint_on(footprint, multum_lobe_map_size(), textureSize(u_normal_map, 0));
  float map_share = multum_normal_map_share(footprint.level);
  vec4 finest = map_share * multum_normal_map_lobe(u_normal_map, st, on_map);
#endif
#ifdef MULTUM_COLOURS
  vec3 mean_colour = vec3(0.0);
#endif
#ifdef MULTUM_BASIS
  float mean_weight = 0.0;
#endif
  MULTUM_EACH_LOBE(j) {
    vec4 lobe = multum_fetch_lobe(j, st, footprint);
#ifdef MULTUM_COLOURS
    // Colours are premultiplied, so T(a c) / T(a) is the lobe's colour.
    vec3 colour = multum_filtered(u_colours[j], st, footprint).rgb;
    surface.albedos[j] = colour / max(lobe.w, MULTUM_AMPLITUDE_MIN);
    mean_colour += colour;
#endif
#ifdef MULTUM_BASIS
    // Shading is linear in (a r, a), so weights act as amplitudes.
    float weight = multum_filtered(u_weights[j], st, footprint)[MULTUM_BASIS];
    mean_weight += weight;
    lobe *= weight / max(lobe.w, MULTUM_AMPLITUDE_MIN);
#endif
    surface.lobes[j] = lobe;
  }
#ifdef MULTUM_WHOLE
  multum_make_whole(surface);
#endif
#ifdef MULTUM_MAGNIFIED
  multum_magnify(surface, multum_footprint_longer_lod(footprint, multum_lobe_map_size()));
#endif
#ifdef MULTUM_NORMAL_MAP
  {
    MULTUM_EACH_LOBE(j) surface.lobes[j] *= 1.0 - map_share;
  }
#ifdef MULTUM_BASIS
  finest *= mean_weight;  // the weight in the first stored level
#endif
  surface.lobes[MULTUM_LOBE_COUNT] = finest;
#if defined(MULTUM_ALBEDO_MAP)
  surface.albedos[MULTUM_LOBE_COUNT] = multum_filtered(u_albedo_map, st, on_map).rgb;
#elif defined(MULTUM_COLOURS)
  surface.albedos[MULTUM_LOBE_COUNT] = mean_colour;  // colour of the first stored level, the finest known
#endif
#endif
#ifdef MULTUM_DRAWN_LOBE
  multum_draw_lobe(surface);
#endif
  return surface;
}
#endif
