/* SPDX-License-Identifier: Apache-2.0
 * Bakes a map that a program made in memory, and looks at one texel. No file is read, and none remains.
 *   cc memory.c -o memory $(pkg-config --cflags --libs multum) -lm
 */
#include <math.h>
#include <multum.h>
#include <stdio.h>

enum { SIZE = 128 };
static float pixels[SIZE][SIZE][3];

/* Waves along x: nx = -slope, scaled to unit length. Values are vectors, -1 to 1. */
static void make_waves(void) {
  for (int y = 0; y < SIZE; ++y)
    for (int x = 0; x < SIZE; ++x) {
      const float slope = 0.5f * sinf(6.2831853f * (float)x / 16.0f), length = sqrtf(1.0f + slope * slope);
      pixels[y][x][0] = -slope / length;
      pixels[y][x][1] = 0.0f;
      pixels[y][x][2] = 1.0f / length;
    }
}

int main(void) {
  multum_error* error = NULL;
  multum_device* device = NULL;
  multum_map* map = NULL;
  multum_lobes lobes;
  multum_image normals = MULTUM_IMAGE_INIT;
  multum_maps maps = MULTUM_MAPS_INIT;
  make_waves();
  normals.width = normals.height = SIZE;
  normals.channels = 3;
  normals.type = MULTUM_FLOAT;
  normals.pixels = pixels;
  maps.normals = &normals;
  if (multum_device_open(NULL, &device, &error) == MULTUM_OK &&
      multum_bake(device, &maps, NULL, NULL, NULL, &map, &error) == MULTUM_OK &&
      multum_map_lookup(map, 0.5, 0.5, 5.0, &lobes, &error) == MULTUM_OK)
    for (int j = 0; j < lobes.count; ++j) {
      const float* a_r = lobes.lobes[j];
      if (a_r[3] > 0.01f)
        printf("lobe %d: amplitude %.2f, mean normal (%.2f, %.2f, %.2f)\n", j, a_r[3], a_r[0] / a_r[3], a_r[1] / a_r[3],
               a_r[2] / a_r[3]);
    }
  else fprintf(stderr, "memory: %s\n", multum_error_message(error));
  const int code = multum_error_status(error);
  multum_error_free(error);
  multum_map_free(map);
  multum_device_free(device);
  return code;
}
