// SPDX-License-Identifier: Apache-2.0
// Decides how a pixel spends its evaluations of the material. An evaluation shades one lobe at one point. If the
// normals under a pixel are similar, evaluations are spent on points, and all lobes of a point are added up to one
// lobe. If the normals scatter, evaluations are spent on lobes, at as many points as the number of evaluations then
// allows. If there are more lobes than evaluations, the most similar lobes are added up. The decision depends on the
// spread 1 - |r| of the sum of all lobes: from MULTUM_SPREAD_OF_LOBES on, evaluations are spent on lobes. A single
// lookup reads this sum, two levels finer than the level of the pixel's longer side.
//
//     float points = multum_movmf_spread(sum) > MULTUM_SPREAD_OF_LOBES ? multum_lobe_points(16.0, 4.0) : 16.0;
//     vec2 grid = multum_point_grid(points, length(dFdx(uv) * size), length(dFdy(uv) * size));
//     for every point:
//       vec2 place = multum_point_place(number, grid);
//       uv + place.x * dFdx(uv) + place.y * dFdy(uv), read with the derivatives dFdx(uv) / grid.x, dFdy(uv) / grid.y

const float MULTUM_SPREAD_OF_LOBES = 0.002;

// Returns the number of points at which each of `lobe_count` lobes is evaluated. This is a power of two of at least 1.
float multum_lobe_points(float evaluations, float lobe_count) {
  return exp2(max(floor(log2(evaluations / lobe_count) + 1e-3), 0.0));
}

// Returns the number of columns and rows of a pixel's points. `count` is a power of two. The parts of the pixel are as
// square as possible on the texture. `along_x` and `along_y` are the lengths of the texture coordinates' derivatives,
// in texels.
vec2 multum_point_grid(float count, float along_x, float along_y) {
  float ratio = max(along_x, along_y) / max(min(along_x, along_y), 1e-20);
  float octaves = ceil(0.5 * log2(count / (2.0 * ratio)) - 1e-3);
  float across = exp2(clamp(octaves, 0.0, floor(0.5 * log2(count) + 1e-3)));
  float along = floor(count / across + 0.5);
  return along_x > along_y ? vec2(along, across) : vec2(across, along);
}

// Returns the offset of point `number` (from 0) from the pixel's middle, in pixels.
vec2 multum_point_place(float number, vec2 grid) {
  float row = floor((number + 0.5) / grid.x);
  return vec2((number - row * grid.x + 0.5) / grid.x - 0.5, (row + 0.5) / grid.y - 0.5);
}

// Returns, for materials without lobes, the variance of the geometry's unit normal over one of `count` parts of a
// pixel, summed over both slopes (Kaplanyan et al. 2016; Tokuyoshi and Kaplanyan 2019). Lobes that are turned by the
// tangent frames of several places already contain this variance.
float multum_geometry_variance(vec3 normal_along_x, vec3 normal_along_y, float count) {
  return (dot(normal_along_x, normal_along_x) + dot(normal_along_y, normal_along_y)) / (12.0 * count);
}

// Returns alpha, increased by the variance of the geometry's normal.
float multum_widened_alpha(float alpha, vec3 normal_along_x, vec3 normal_along_y, float count) {
  return sqrt(min(alpha * alpha + multum_geometry_variance(normal_along_x, normal_along_y, count), 1.0));
}
