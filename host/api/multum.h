/* SPDX-License-Identifier: Apache-2.0 */
/* multum.h: bakes, reads and shades textures that look right at every distance, from C.
 *
 * A first program (examples/bake.c is longer):
 *
 *     multum_error* error = NULL;
 *     multum_device* device = NULL;
 *     multum_map* map = NULL;
 *     multum_maps maps = MULTUM_MAPS_INIT;
 *     maps.input = "bricks_normal.png";
 *     if (multum_device_open(NULL, &device, &error) == MULTUM_OK &&
 *         multum_bake(device, &maps, NULL, "bricks.ndf.exr", NULL, &map, &error) == MULTUM_OK)
 *       printf("%d levels\n", multum_map_info(map).level_count);
 *     else
 *       printf("%s\n", multum_error_message(error));
 *     multum_error_free(error);
 *     multum_map_free(map);
 *     multum_device_free(device);
 *
 * OBJECTS. Every object is an opaque handle with a function ..._free(), which takes NULL too. Objects do not depend on
 * each other: a map stays valid when the device that baked it is freed.
 *
 * ERRORS. A function that can fail returns a multum_status. On failure it also makes a multum_error, unless its last
 * argument is NULL; the caller frees the error. On success, and if the argument is NULL, no error is made. Functions
 * without a status cannot fail. No function throws an exception, ends the process, prints, installs a signal handler
 * or changes an environment variable. Messages name settings ("lobes is 9, expected an integer from 1 to 8").
 *
 * THREADS. Functions can be called from any thread. Two threads may use different objects at the same time. Two threads
 * may also use one map, one BRDF or one device: calls that would disturb each other wait for each other. Only
 * ..._free() and multum_values_set_...() need an object that no other thread uses.
 *
 * STRUCTS that callers fill begin with their own size, which the ..._INIT macros set. A later library accepts the
 * structs of earlier headers.
 *
 * DEVICES. Bakes, exports and measurements need OpenCL. Reading, filtering, shading and sampling do not: libOpenCL.so.1
 * is loaded by the first multum_device_open() or multum_list_devices(). With PoCL and LLVM 18, some processors need
 * POCL_WORK_GROUP_METHOD=cbs in the environment; multum_device_open() then returns an error that says so.
 *
 * COORDINATES. Directions are unit vectors in tangent space: +X right (u grows), +Y up (towards the first row of the
 * image), +Z out of the surface. Rows are stored from the top of the image to the bottom. Level 0 is the finest level.
 */
#ifndef MULTUM_H
#define MULTUM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define MULTUM_API __attribute__((visibility("default")))
#else
#define MULTUM_API
#endif

/* ---------------------------------------------------------------------------------------------------- errors -- */

typedef enum multum_status {
  MULTUM_OK = 0,
  MULTUM_CANCELLED = 1,       /* a progress callback asked to stop */
  MULTUM_BAD_SETTING = 2,     /* an argument or the value of a setting is wrong */
  MULTUM_BAD_INPUT = 3,       /* a file or an image cannot be used */
  MULTUM_BAD_ENVIRONMENT = 4, /* the device, the driver or the disk cannot do the work at present */
  MULTUM_NOT_VERIFIED = 5,    /* a check of a finished file failed, or no settings reach a target */
  MULTUM_OUT_OF_MEMORY = 6,
  MULTUM_INTERNAL = 7 /* a fault of the library; please report its message */
} multum_status;

typedef struct multum_error multum_error;

/* Return parts of an error. The texts are valid until the error is freed, and never NULL. If the error is NULL, the
 * status is MULTUM_OK and the texts are empty. */
MULTUM_API multum_status multum_error_status(const multum_error* error);
MULTUM_API const char* multum_error_message(const multum_error* error);
MULTUM_API const char* multum_error_file(const multum_error* error);     /* file that the message is about, or "" */
MULTUM_API const char* multum_error_found(const multum_error* error);    /* value that was found, or "" */
MULTUM_API const char* multum_error_expected(const multum_error* error); /* value that was expected, or "" */
MULTUM_API void multum_error_free(multum_error* error);

/* Returns the version of the library, such as "0.1.0". */
MULTUM_API const char* multum_version(void);

/* A text that the caller frees. */
typedef struct multum_text multum_text;
MULTUM_API const char* multum_text_get(const multum_text* text); /* "" for NULL */
MULTUM_API void multum_text_free(multum_text* text);

/* -------------------------------------------------------------------------------------------------- callbacks -- */

typedef enum multum_log_kind { MULTUM_WARNING = 0, MULTUM_INFO = 1, MULTUM_VERBOSE = 2 } multum_log_kind;

/* Functions of the caller; each may be NULL. A long call reports its progress from the thread that made the call, and
 * its log from any of its threads, one message at a time. A callback must not use an object of the running call. */
typedef struct multum_callbacks {
  size_t size;
  void* user; /* passed to the callbacks */
  /* `stage`: the current work, such as "fit level 3". `share`: finished share of the work, 0 to 1; below 0 while it is
   * unknown. Returns 0 to continue. With any other value the call ends with MULTUM_CANCELLED, leaves no file, and all
   * objects remain usable. */
  int (*progress)(void* user, const char* stage, double share);
  void (*log)(void* user, multum_log_kind kind, const char* message);
} multum_callbacks;
#define MULTUM_CALLBACKS_INIT \
  { sizeof(multum_callbacks), NULL, NULL, NULL }

/* --------------------------------------------------------------------------------------------------- settings -- */

/* Values for the settings of a command: "bake", "export", "gltf", "infer" or "pack". The names, ranges and defaults
 * are those of docs/reference/commands.md, with underscores instead of hyphens: "first_level". Settings that were not
 * set have their defaults. */
typedef struct multum_values multum_values;

MULTUM_API multum_status multum_values_new(const char* command, multum_values** values, multum_error** error);
MULTUM_API void multum_values_free(multum_values* values);
/* Set one value. multum_values_set_text() takes every kind of value in the form of a command line: "4", "0.05",
 * "800M", "true". Return MULTUM_BAD_SETTING for an unknown name or an illegal value. */
MULTUM_API multum_status multum_values_set_text(multum_values* values, const char* name, const char* value,
                                                multum_error** error);
MULTUM_API multum_status multum_values_set_number(multum_values* values, const char* name, double value,
                                                  multum_error** error);
MULTUM_API multum_status multum_values_set_flag(multum_values* values, const char* name, int value,
                                                multum_error** error);

typedef struct multum_parameter {
  const char* name;
  const char* help;   /* the effect, verb first */
  const char* values; /* the legal values and the default: "an integer from 1 to 8, default 4" */
} multum_parameter;
/* Returns the number of settings of a command; 0 for an unknown command. */
MULTUM_API int multum_parameter_count(const char* command);
/* Describes setting `index` of a command. The texts are static. All are empty if there is no such setting. */
MULTUM_API multum_parameter multum_parameter_at(const char* command, int index);

/* ---------------------------------------------------------------------------------------------------- devices -- */

typedef struct multum_device multum_device;

/* Opens an OpenCL device. `selector`: NULL or "" for the first GPU, or the first CPU if there is none; a number of
 * multum_list_devices(); or a part of the name of a device or platform. The first call in a process takes the time
 * that the driver needs to load, 0.1 to 1 s. */
MULTUM_API multum_status multum_device_open(const char* selector, multum_device** device, multum_error** error);
MULTUM_API const char* multum_device_name(const multum_device* device);
MULTUM_API void multum_device_free(multum_device* device);
/* Calls `each` once for each device. */
MULTUM_API multum_status multum_list_devices(void (*each)(void* user, int index, const char* name,
                                                          const char* platform),
                                             void* user, multum_error** error);

/* ------------------------------------------------------------------------------------------------------ bakes -- */

typedef enum multum_type {
  MULTUM_UINT8 = 0,
  MULTUM_UINT16 = 1,
  MULTUM_HALF = 2, /* IEEE 16-bit float */
  MULTUM_FLOAT = 3,
  MULTUM_SNORM16 = 4 /* int16_t, v / 32767; only for reading */
} multum_type;

/* An image in memory: rows from the top, channels interleaved. */
typedef struct multum_image {
  size_t size;
  int width, height; /* texels, at least 1 */
  int channels;      /* 1 to 4: grey; grey, alpha; red, green, blue; red, green, blue, alpha */
  multum_type type;
  ptrdiff_t row_bytes; /* from one row to the next; 0: rows follow each other */
  const void* pixels;  /* the first row; the caller keeps the memory unchanged during the call */
} multum_image;
#define MULTUM_IMAGE_INIT \
  { sizeof(multum_image), 0, 0, 0, MULTUM_UINT8, 0, NULL }

/* The maps of a material: files or images in memory, either of which may be absent except for the normals. Files of
 * other maps are settings: "albedo", "roughness", "weights". Files are decoded in a child process, so that a broken
 * file cannot crash the caller; images in memory need no child process. */
typedef struct multum_maps {
  size_t size;
  const char* input; /* file with a normal map or a height field; NULL if `normals` is given */
  const multum_image *normals, *albedo, *roughness, *weights;
} multum_maps;
#define MULTUM_MAPS_INIT \
  { sizeof(multum_maps), NULL, NULL, NULL, NULL, NULL }

typedef struct multum_map multum_map;

/* Bakes a mipmap of distributions of normals, as `multum bake` does with the same settings: equal settings and pixels
 * give equal texels. `values`: of "bake", or NULL for the defaults. `output`: the file to write, which appears complete
 * or not at all; NULL to keep the result in a temporary file that multum_map_free() removes. `map` may be NULL if
 * there is an output. */
MULTUM_API multum_status multum_bake(multum_device* device, const multum_maps* maps, const multum_values* values,
                                     const char* output, const multum_callbacks* callbacks, multum_map** map,
                                     multum_error** error);

/* Exports a map as a material of one lobe per texel, as `multum export` does. `output`: a folder, or NAME.ktx2 or
 * NAME.dds. `report`: receives JSON, the contents of `multum export --report`; may be NULL. */
MULTUM_API multum_status multum_export(multum_device* device, const multum_maps* maps, const multum_values* values,
                                       const char* output, const multum_callbacks* callbacks, multum_text** report,
                                       multum_error** error);

/* Writes a copy of a glTF model whose textures have fitted mips, as `multum gltf` does. `input`: *.glb, or *.gltf with
 * its files. `output`: *.glb. `values`: of "gltf", or NULL. `report`: receives the JSON of `multum gltf --report`; may
 * be NULL. */
MULTUM_API multum_status multum_convert_model(multum_device* device, const char* input, const multum_values* values,
                                              const char* output, const multum_callbacks* callbacks,
                                              multum_text** report, multum_error** error);

/* Measures the error of a baked file against the maps that it was baked from, as the bake did. `values`: those of the
 * bake. Returns MULTUM_NOT_VERIFIED if the file is damaged. `errors`: receives the JSON array of
 * multum_map_text(map, "measured_error"). */
MULTUM_API multum_status multum_measure(multum_device* device, const char* baked, const multum_maps* maps,
                                        const multum_values* values, const multum_callbacks* callbacks,
                                        multum_text** errors, multum_error** error);

/* ------------------------------------------------------------------------------------------------ baked maps -- */

typedef struct multum_info {
  int width, height;        /* of level 0 */
  int level_count;          /* down to 1 x 1 */
  int first_level;          /* the finest stored level */
  int lobe_count;           /* 0 if texels are not lobes */
  int sh_order;             /* of spherical harmonics; 0 for other maps */
  int has_colours;          /* 0 or 1 */
  int weight_count;         /* weights of basis BRDFs, 0 to 4 */
  int repeats_s, repeats_t; /* 1: the map repeats along u, v; 0: it ends at its border */
} multum_info;

/* Parts of a texel. Values of a level are float arrays [layer][row][column][channel]. */
typedef enum multum_part {
  MULTUM_LOBES = 0,        /* a layer per lobe: (a r_x, a r_y, a r_z, a); amplitude a, mean vector r, |r| <= 1 */
  MULTUM_COLOURS = 1,      /* linear RGB; for lobes a layer per lobe, multiplied by a */
  MULTUM_WEIGHTS = 2,      /* weights of basis BRDFs; for lobes a layer per lobe, multiplied by a */
  MULTUM_SLOPES = 3,       /* moments of slopes: height, E[s], E[t], E[s^2], E[t^2], E[s t] */
  MULTUM_MEAN_NORMALS = 4, /* mean normal, |n| <= 1; stored with the moments */
  MULTUM_HARMONICS = 5     /* a layer per four coefficients of spherical harmonics */
} multum_part;

/* Opens a baked file. Reads only its header. */
MULTUM_API multum_status multum_map_open(const char* path, multum_map** map, multum_error** error);
MULTUM_API void multum_map_free(multum_map* map);
MULTUM_API multum_info multum_map_info(const multum_map* map);
/* Returns a text of the header: "representation" (vmf, gmm, moments or sh), "encoding" (snorm16, half or float),
 * "content_hash", "source_name", "source_hash", "settings", "measured_error", "reading", "software"; or "report", the
 * JSON report of the bake that made this object. Returns "" for other keys and for texts that the file lacks. Valid
 * until the map is freed. */
MULTUM_API const char* multum_map_text(multum_map* map, const char* key);
/* Writes a copy of the file; the copy appears complete or not at all. */
MULTUM_API multum_status multum_map_save(multum_map* map, const char* path, multum_error** error);

/* Values of one part of one level. They belong to the map, are read at the first call, and are valid until
 * multum_map_forget() or multum_map_free(). */
typedef struct multum_view {
  const float* values; /* [layer][row][column][channel] */
  int layers, height, width, channels;
} multum_view;
MULTUM_API multum_status multum_map_level(multum_map* map, int level, multum_part part, multum_view* view,
                                          multum_error** error);
/* Frees the levels that the map keeps in memory. */
MULTUM_API void multum_map_forget(multum_map* map);

/* Copies a region of a level, without keeping it: columns x to x + width - 1 of rows y to y + height - 1. Reads only
 * the rows of tiles that hold the region. `type`: MULTUM_FLOAT, MULTUM_HALF, or MULTUM_SNORM16 for files of encoding
 * snorm16. `values`: room for layers * height * width * channels values; multum_map_shape() returns the counts. */
typedef struct multum_region {
  int x, y, width, height;
} multum_region;
MULTUM_API multum_status multum_map_read(multum_map* map, int level, multum_part part, multum_region region,
                                         multum_type type, void* values, multum_error** error);
/* Returns the shape of a part of a level, with values NULL; all counts are 0 if the map has no such part or level. */
MULTUM_API multum_view multum_map_shape(const multum_map* map, int level, multum_part part);

/* --------------------------------------------------------------------------------------------------- shading -- */

#define MULTUM_LOBES_MAX 8

/* The lobes of one texel or of a filtered lookup. Only maps of representation vmf have such lobes. */
typedef struct multum_lobes {
  int count;
  int has_colours;
  float lobes[MULTUM_LOBES_MAX][4];   /* (a r_x, a r_y, a r_z, a) */
  float colours[MULTUM_LOBES_MAX][3]; /* a * linear RGB; only if has_colours */
} multum_lobes;

/* Filters the lobes at texture coordinates (u, v) linearly in and between levels, as graphics hardware does. v = 0 is
 * the top of the image. `level`: level of detail, 0 is the finest; it is clamped to the stored levels. Loads the levels
 * that it needs and keeps them, so that later calls take less than a microsecond. */
MULTUM_API multum_status multum_map_lookup(multum_map* map, double u, double v, double level, multum_lobes* lobes,
                                           multum_error** error);

typedef struct multum_brdf multum_brdf;

/* Makes a BRDF: "lambert", "blinn-phong:100", "ggx:0.4", "ggx:0.4,0.04" (roughness, F0), or another form of
 * docs/reference/commands.md; or the file of a measured BRDF. Fits its vMF terms, which takes milliseconds. */
MULTUM_API multum_status multum_brdf_new(const char* text, multum_brdf** brdf, multum_error** error);
MULTUM_API void multum_brdf_free(multum_brdf* brdf);

/* Computes the light that a texel reflects from a direction `light` towards `view`: the integral over the texel's
 * normals n of BRDF * max(n . light, 0), in linear RGB, for light of irradiance 1 perpendicular to its direction. Uses
 * the formulas of the GL runtime, in double. The colours of `lobes` multiply the diffuse part; without colours, the
 * albedo is the BRDF's own. The result is 0 if `light` or `view` points below the horizon. */
MULTUM_API void multum_shade(const multum_lobes* lobes, const multum_brdf* brdf, const double light[3],
                             const double view[3], double rgb[3]);

/* Returns the density of normals at `normal`, per steradian. It integrates to the sum of the amplitudes. */
MULTUM_API double multum_density(const multum_lobes* lobes, const double normal[3]);

/* Draws a light direction in proportion to an approximation of multum_shade() for this `view`. `random`: three numbers
 * in [0, 1). Stores the direction and returns its density per steradian; the direction may point below the horizon,
 * where multum_shade() is 0. Returns 0 if there is nothing to sample. */
MULTUM_API double multum_sample(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3],
                                const double random[3], double light[3]);
/* Returns the density with which multum_sample() draws `light`, per steradian. */
MULTUM_API double multum_pdf(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3],
                             const double light[3]);

#ifdef __cplusplus
}
#endif

#endif
