// SPDX-License-Identifier: Apache-2.0
// Draws an object with its inferred texture. Rows of textures start at the image's top, so t = 1 - v. The probe and the
// pictures share this text, so they draw the same geometry.
layout(location = 0) in vec3 a_position;
layout(location = 3) in vec2 a_uv;

uniform mat4 u_object_to_clip;

out vec2 v_st;
invariant gl_Position;

void main() {
  v_st = vec2(a_uv.x, 1.0 - a_uv.y);
  gl_Position = u_object_to_clip * vec4(a_position, 1.0);
}
