// SPDX-License-Identifier: Apache-2.0
// Hands one sample's picture on; blending adds it to the sum. (Blending while drawing the mesh would also add surfaces
// that a nearer triangle hides later.)
uniform sampler2D u_picture;
layout(location = 0) out vec4 o_colour;
void main() { o_colour = texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0); }
