// SPDX-License-Identifier: Apache-2.0
// Computes the light that a normal-mapped surface sends to the eye. A file of surface/ provides its normals, a file of
// brdf/ its BRDF, and light/ its lights (common/reflection.glsl describes the interface of these files). All vectors
// are converted to tangent space, which is the space of the map's normals.
//
// The outgoing radiance is the sum over lights of the BRDF times max(n.l, 0), averaged over n. MULTUM_REFERENCE
// averages over samples. The models of the other variants include the average, with cosines per lobe or of the averaged
// normal.
// With MULTUM_SHADE_TAPS, each tap of the texture filter is shaded separately, and the results are averaged. With
// MULTUM_EVALUATIONS n, there are n evaluations of the material, by common/evaluations.glsl. With MULTUM_TURNED, the
// lobes of evaluations are read at 2 x 2 or more places of the pixel, and turned by the frame of each place.
in vec3 v_position;
in vec3 v_normal;
in vec4 v_tangent;
in vec2 v_st;

uniform vec3 u_eye;

layout(location = 0) out vec4 o_colour;

#ifdef MULTUM_TURNED
// Sets multum_turn_variance for one of `count` parts of the pixel. Takes derivatives.
void multum_take_turn(float count) {
  vec3 normal = normalize(v_normal);
  multum_turn_variance = multum_geometry_variance(dFdx(normal), dFdy(normal), count);
}
#endif

#ifdef MULTUM_EVALUATIONS
struct MultumDerivatives {
  vec2 st;
  vec3 position, normal;
  vec4 tangent;
};

MultumDerivatives multum_along_x, multum_along_y;

mat3 multum_frame_at(vec2 place) {
  return multum_tangent_frame(v_normal + place.x * multum_along_x.normal + place.y * multum_along_y.normal,
                              v_tangent + place.x * multum_along_x.tangent + place.y * multum_along_y.tangent);
}

MultumSurface multum_fetch_at(vec2 place, MultumFootprint footprint) {
  return multum_fetch_surface(v_st + place.x * multum_along_x.st + place.y * multum_along_y.st, footprint);
}

#if defined(MULTUM_TURNED) && defined(MULTUM_LOBES_ADD_UP)
// Returns the lobes of a part of the pixel about `middle`. This is the mean over `places`, each converted to `frame`.
MultumSurface multum_fetch_turned(vec2 middle, vec2 part, vec2 places, mat3 frame, MultumFootprint footprint) {
  MultumSurface sum;
  for (int j = 0; j < MULTUM_PART_COUNT; ++j) {
    sum.lobes[j] = vec4(0.0);
#ifdef MULTUM_COLOURS
    sum.albedos[j] = vec3(0.0);
#endif
  }
#ifdef MULTUM_MEAN_COLOURS
  sum.albedo = vec3(0.0);
#endif
  float count = places.x * places.y;
  for (float i = 0.0; i < count; ++i) {
    vec2 place = middle + part * multum_point_place(i, places);
    mat3 turn = transpose(frame) * multum_frame_at(place);
    MultumSurface one = multum_fetch_at(place, footprint);
#ifdef MULTUM_MEAN_COLOURS
    sum.albedo += one.albedo / count;
#endif
    for (int j = 0; j < MULTUM_PART_COUNT; ++j) {
      sum.lobes[j] += vec4(turn * one.lobes[j].xyz, one.lobes[j].w) / count;
#ifdef MULTUM_COLOURS
      sum.albedos[j] += one.lobes[j].w / count * one.albedos[j];
#endif
    }
  }
#ifdef MULTUM_COLOURS
  for (int j = 0; j < MULTUM_PART_COUNT; ++j) sum.albedos[j] /= max(sum.lobes[j].w, MULTUM_AMPLITUDE_MIN);
#endif
  return sum;
}
#endif

vec3 multum_evaluated() {
  multum_along_x = MultumDerivatives(dFdx(v_st), dFdx(v_position), dFdx(v_normal), dFdx(v_tangent));
  multum_along_y = MultumDerivatives(dFdy(v_st), dFdy(v_position), dFdy(v_normal), dFdy(v_tangent));
  vec2 size = vec2(multum_surface_size());
  float points = float(MULTUM_EVALUATIONS);
#ifdef MULTUM_LOBE_COUNT
  float lobe_points = multum_lobe_points(points, float(MULTUM_LOBE_COUNT));
#if !defined(MULTUM_LOBES_ADD_UP)
  points = lobe_points;
#elif MULTUM_EVALUATIONS == 1
  multum_part_count = 1;
#else
  MultumFootprint finer = multum_surface_footprint(v_st);
  float level = finer.level;
  finer = MultumFootprint(vec2(0.0), 1, multum_footprint_longer_lod(finer, multum_surface_size()) - 2.0);
  bool pays = multum_spread_of_all(multum_fetch_surface(v_st, finer)) > MULTUM_SPREAD_OF_LOBES;
#ifdef MULTUM_NORMAL_MAP
  // One octave finer, the normal map replaces the lobes, so there are no lobes to evaluate.
  if (multum_normal_map_share(level - 1.0) > 0.0) pays = false;
#elif !defined(MULTUM_MAGNIFIED)
  // Between texels, the filter mixes the light of the surrounding texels, which act as separate lobes.
  if (level < 1.0) pays = true;
#endif
  if (pays) points = lobe_points;
  multum_part_count = pays ? min(MULTUM_PART_COUNT, MULTUM_EVALUATIONS) : 1;
#endif
#endif
#ifdef MULTUM_TURNED
  multum_take_turn(points);
#endif
  vec2 grid = multum_point_grid(points, length(multum_along_x.st * size), length(multum_along_y.st * size));
  vec2 part = 1.0 / grid;
  vec2 places = vec2(1.0);
#if defined(MULTUM_TURNED) && defined(MULTUM_LOBES_ADD_UP)
  places = max(floor(2.0 / grid), vec2(1.0));
#endif
  multum_part = part / places;
  MultumFootprint footprint = multum_surface_footprint(v_st);
#ifdef MULTUM_ROUGHNESS_TEXTURE
  multum_part = part;
  MultumFootprint of_roughness = multum_roughness_footprint(v_st);
#endif
  vec3 sum = vec3(0.0);
  for (float i = 0.0; i < points; ++i) {
    vec2 place = multum_point_place(i, grid);
    mat3 to_world = multum_frame_at(place);
    vec3 position = v_position + place.x * multum_along_x.position + place.y * multum_along_y.position;
#ifdef MULTUM_ROUGHNESS_TEXTURE
    multum_take_roughness(v_st + place.x * multum_along_x.st + place.y * multum_along_y.st, of_roughness);
#endif
#if defined(MULTUM_TURNED) && defined(MULTUM_LOBES_ADD_UP)
    MultumSurface surface = multum_fetch_turned(place, part, places, to_world, footprint);
#else
    MultumSurface surface = multum_fetch_at(place, footprint);
#endif
#ifdef MULTUM_LOBES_ADD_UP
    if (multum_part_count == 1) multum_add_up(surface);
    else if (multum_part_count < MULTUM_LOBE_COUNT) multum_add_up_alike(surface);
#endif
    sum += multum_lights(surface, to_world, position, normalize(u_eye - position) * to_world);
  }
  return sum / points;
}
#endif

void main() {
#ifdef MULTUM_EVALUATIONS
  o_colour = vec4(multum_evaluated(), 1.0);
#else
#ifdef MULTUM_TURNED
  multum_take_turn(1.0);
#endif
  mat3 to_world = multum_tangent_frame(v_normal, v_tangent);
  vec3 v = normalize(u_eye - v_position) * to_world;
  MultumFootprint footprint = multum_surface_footprint(v_st);
#ifdef MULTUM_ROUGHNESS_TEXTURE
  MultumFootprint of_roughness = multum_roughness_footprint(v_st);
  multum_take_roughness(v_st, of_roughness);
#endif
#ifdef MULTUM_SHADE_TAPS
  MultumFootprint one = MultumFootprint(vec2(0.0), 1, footprint.level);
  vec2 place = multum_first_tap(v_st, footprint);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < footprint.tap_count; ++i) {
    vec2 tap = place + float(i) * footprint.tap_step;
#ifdef MULTUM_ROUGHNESS_TEXTURE
    multum_take_roughness(tap, MultumFootprint(vec2(0.0), 1, of_roughness.level));
#endif
    sum += multum_lights(multum_fetch_surface(tap, one), to_world, v_position, v);
  }
  o_colour = vec4(sum / float(footprint.tap_count), 1.0);
#else
  o_colour = vec4(multum_lights(multum_fetch_surface(v_st, footprint), to_world, v_position, v), 1.0);
#endif
#endif
}
