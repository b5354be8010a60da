/* SPDX-License-Identifier: Apache-2.0
 * Bakes a normal map and prints its levels.
 *   cc bake.c -o bake $(pkg-config --cflags --libs multum)
 *   ./bake bricks_normal.png bricks.ndf.exr
 */
#include <multum.h>
#include <stdio.h>

static int show_progress(void* user, const char* stage, double share) {
  (void)user;
  if (share >= 0) fprintf(stderr, "\r%3.0f %% %-40s", 100 * share, stage);
  return 0; /* 1 would cancel the bake */
}

static void show_log(void* user, multum_log_kind kind, const char* message) {
  (void)user;
  if (kind == MULTUM_WARNING) fprintf(stderr, "\nwarning: %s\n", message);
}

static multum_status bake(const char* input, const char* output, multum_error** error) {
  multum_device* device = NULL;
  multum_values* values = NULL;
  multum_map* map = NULL;
  multum_maps maps = MULTUM_MAPS_INIT;
  multum_callbacks callbacks = MULTUM_CALLBACKS_INIT;
  maps.input = input;
  callbacks.progress = show_progress;
  callbacks.log = show_log;

  multum_status status = multum_device_open(NULL, &device, error);
  if (status == MULTUM_OK) status = multum_values_new("bake", &values, error);
  if (status == MULTUM_OK) status = multum_values_set_number(values, "lobes", 4, error);
  if (status == MULTUM_OK) status = multum_bake(device, &maps, values, output, &callbacks, &map, error);
  if (status == MULTUM_OK) {
    const multum_info info = multum_map_info(map);
    printf("%s: %d lobes per texel, baked on %s\n", output, info.lobe_count, multum_device_name(device));
    for (int level = info.first_level; level < info.level_count; ++level) {
      const multum_view shape = multum_map_shape(map, level, MULTUM_LOBES);
      printf("level %d: %d x %d texels\n", level, shape.width, shape.height);
    }
  }
  multum_map_free(map);
  multum_values_free(values);
  multum_device_free(device);
  return status;
}

int main(int argc, char** argv) {
  multum_error* error = NULL;
  if (argc != 3) {
    fprintf(stderr, "bake: found %d arguments, expected a normal map and the file to write\n", argc - 1);
    return 2;
  }
  if (bake(argv[1], argv[2], &error) != MULTUM_OK) fprintf(stderr, "\nbake: %s\n", multum_error_message(error));
  const int code = multum_error_status(error);
  multum_error_free(error);
  return code;
}
