// SPDX-License-Identifier: Apache-2.0
// Converts directions in tangent space to the environment's frame and to places in its map.
uniform vec3 u_environment_axes[3];  // the environment's x, y and z in the world
uniform sampler2D u_environment_map;

mat3 multum_environment_frame;  // rotation from tangent space to the environment's frame; set by main()

void multum_set_environment_frame(mat3 to_world) {
  multum_environment_frame =
      transpose(mat3(u_environment_axes[0], u_environment_axes[1], u_environment_axes[2])) * to_world;
}

// `d` is in the environment's frame. Straight up and down, where atan(0, 0) is undefined, any value of s is correct.
vec2 multum_environment_st(vec3 d) {
  float ahead = d.x == 0.0 && d.z == 0.0 ? 1.0 : -d.z;
  return vec2(0.5 + atan(d.x, ahead) / (2.0 * MULTUM_PI), acos(clamp(d.y, -1.0, 1.0)) / MULTUM_PI);
}
