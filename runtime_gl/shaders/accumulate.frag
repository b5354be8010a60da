// SPDX-License-Identifier: Apache-2.0
// Outputs one sample's picture, which blending adds to the sum. (Blending while the mesh is drawn would also add
// surfaces that nearer triangles hide later.)
uniform sampler2D u_picture;
layout(location = 0) out vec4 o_colour;
void main() { o_colour = texelFetch(u_picture, ivec2(gl_FragCoord.xy), 0); }
