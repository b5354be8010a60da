// SPDX-License-Identifier: Apache-2.0
// Draws a mesh as a camera sees it. Positions are in world space. Rows of textures start at the image's top, so
// t = 1 - v.
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec4 a_tangent;
layout(location = 3) in vec2 a_uv;

uniform mat4 u_view_projection;
uniform float u_uv_scale;

out vec3 v_position;
out vec3 v_normal;
out vec4 v_tangent;
out vec2 v_st;

void main() {
  v_position = a_position;
  v_normal = a_normal;
  v_tangent = a_tangent;
  v_st = vec2(a_uv.x, 1.0 - a_uv.y) * vec2(u_uv_scale, u_uv_scale);
  gl_Position = u_view_projection * vec4(a_position, 1.0);
}
