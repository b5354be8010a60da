// SPDX-License-Identifier: Apache-2.0
// The settings of kernels/plane_picture.cl. This file is valid OpenCL C and C++.
#ifndef MULTUM_KERNELS_SHARED_PLANE_PICTURE_H
#define MULTUM_KERNELS_SHARED_PLANE_PICTURE_H

#define MULTUM_PLANE_TERMS 4
#define MULTUM_PLANE_FRESNEL_STEPS 256  // steps of v.h from 0 to 1 in the table of F

// The visibility term V of a BRDF.
#define MULTUM_PLANE_V_ONE 0
#define MULTUM_PLANE_V_GROOVES 1  // Cook and Torrance 1982
#define MULTUM_PLANE_V_SMITH 2    // GGX
#define MULTUM_PLANE_V_SHEEN 3    // Ashikhmin and Premoze 2007

// One tile of the map covers 0 <= x <= 1 and 0 <= y <= 1 of the plane z = 0. The first row of the map is at y = 1.
typedef struct MultumPlanePicture {
  float eye[3];
  float corner[3], along_x[3], along_y[3];  // the ray of pixel (x, y) is corner + (x + 1/2) along_x + (y + 1/2) along_y
  float light[3];                           // unit vector towards the light
  int width, height;                        // of the picture, in pixels
  int map_width, map_height;                // of level 0, in texels
  int first_level, last_level;              // the stored levels
  int level;                                // draws the pixels that mix this level with the next coarser one
  int wrap_s, wrap_t;                       // 0: black, 1: clamped, 2: repeated, 3: mirrored
  int taps;                                 // the largest number of lookups along the longer side of a footprint
  int has_colours, has_diffuse_fresnel;     // 0 or 1
  int is_blinn_phong;                       // 1 if the highlight is a Blinn-Phong lobe; `terms` then has one weight
  int visibility;                           // MULTUM_PLANE_V_...
  int term_count;                           // number of vMF terms of the highlight; 0 for no highlight
  float exponent;                           // of the Blinn-Phong lobe that is as wide as the highlight
  float alpha;                              // of GGX
  float mean_cosine;                        // if above 0, the lobes contain roughness of this mean cosine
  float weights[MULTUM_PLANE_TERMS][3], spreads[MULTUM_PLANE_TERMS];
  float diffuse[3], specular[3];  // k_d, k_s
} MultumPlanePicture;

#endif
