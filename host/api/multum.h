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
 * OBJECTS. Every object is an opaque handle. It is freed by a function ..._free(), which also accepts NULL. Objects do
 * not depend on each other. For example, a map stays valid when the device that baked it is freed.
 *
 * ERRORS. A function that can fail returns a multum_status. If it fails and its last argument is not NULL, it also
 * makes a multum_error, which the caller must free. Otherwise it makes no error. Functions that do not return a status
 * cannot fail. No function throws an exception, ends the process, prints, installs a signal handler or changes an
 * environment variable. Messages name settings ("lobes is 9, expected an integer from 1 to 8").
 *
 * THREADS. Functions can be called from any thread. Two threads may use different objects at the same time. Two threads
 * may also use the same map, BRDF or device, because calls that would disturb each other wait. The exceptions are
 * ..._free(), multum_map_forget() and multum_values_set_...(). Call them only when no other thread uses the object. A
 * callback must not use the device of the running call; such a call returns an error.
 *
 * STRUCTS. multum_callbacks, multum_image, multum_maps and multum_plane begin with their own size, which the ..._INIT
 * macros set. Later versions of the library accept the structs of earlier headers.
 *
 * DEVICES. Bakes, exports and measurements need OpenCL. Reading, filtering, shading and sampling do not need it,
 * because libOpenCL.so.1 is loaded only by the first call of multum_device_open() or multum_list_devices(). With PoCL
 * and LLVM 18, the environment must contain POCL_WORK_GROUP_METHOD=cbs. If this variable is missing,
 * multum_device_open() returns an error that says so.
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

/* Return the parts of an error. The texts are never NULL, and are valid until the error is freed. If `error` is NULL,
 * the status is MULTUM_OK and the texts are empty. */
MULTUM_API multum_status multum_error_status(const multum_error* error);
MULTUM_API const char* multum_error_message(const multum_error* error);
MULTUM_API const char* multum_error_file(const multum_error* error);     /* the file that the message is about, or "" */
MULTUM_API const char* multum_error_found(const multum_error* error);    /* the value that was found, or "" */
MULTUM_API const char* multum_error_expected(const multum_error* error); /* the value that was expected, or "" */
MULTUM_API void multum_error_free(multum_error* error);

/* Returns the version of the library, such as "0.1.0". */
MULTUM_API const char* multum_version(void);

/* A text that the caller frees. */
typedef struct multum_text multum_text;
MULTUM_API const char* multum_text_get(const multum_text* text); /* "" for NULL */
MULTUM_API void multum_text_free(multum_text* text);

/* -------------------------------------------------------------------------------------------------- callbacks -- */

typedef enum multum_log_kind { MULTUM_WARNING = 0, MULTUM_INFO = 1, MULTUM_VERBOSE = 2 } multum_log_kind;

/* Functions of the caller. Each of them may be NULL. A long call reports its progress from the thread that made the
 * call. It passes its log from any of its threads, one message at a time. A callback must not use an object that the
 * running call uses. */
typedef struct multum_callbacks {
  size_t size;
  void* user; /* passed to the callbacks */
  /* `stage` names the current work, such as "fit level 3". `share` is the finished share of the work, from 0 to 1. It
   * is negative while the share is unknown. The function returns 0 to continue. If it returns any other value, the call
   * ends with MULTUM_CANCELLED and leaves no file. All objects remain usable. */
  int (*progress)(void* user, const char* stage, double share);
  void (*log)(void* user, multum_log_kind kind, const char* message);
} multum_callbacks;
#define MULTUM_CALLBACKS_INIT \
  { sizeof(multum_callbacks), NULL, NULL, NULL }

/* --------------------------------------------------------------------------------------------------- settings -- */

/* Values for the settings of a command: "bake", "export", "gltf", "infer" or "pack". The names, ranges and defaults are
 * those of docs/reference/commands.md, with underscores instead of hyphens: "first_level". Settings that are not set
 * have their default values. */
typedef struct multum_values multum_values;

MULTUM_API multum_status multum_values_new(const char* command, multum_values** values, multum_error** error);
MULTUM_API void multum_values_free(multum_values* values);
/* Set one value. multum_values_set_text() accepts every kind of value in the form used on command lines, such as "4",
 * "0.05", "800M" or "true". All return MULTUM_BAD_SETTING for an unknown name or an illegal value. */
MULTUM_API multum_status multum_values_set_text(multum_values* values, const char* name, const char* value,
                                                multum_error** error);
MULTUM_API multum_status multum_values_set_number(multum_values* values, const char* name, double value,
                                                  multum_error** error);
MULTUM_API multum_status multum_values_set_flag(multum_values* values, const char* name, int value,
                                                multum_error** error);

typedef struct multum_parameter {
  const char* name;
  const char* help;   /* describes the effect, beginning with a verb */
  const char* values; /* the legal values and the default: "an integer from 1 to 8, default 4" */
} multum_parameter;
/* Returns the number of settings of a command, or 0 if the command is unknown. */
MULTUM_API int multum_parameter_count(const char* command);
/* Describes setting number `index` of a command, counted from 0. The texts are static. If there is no such setting, all
 * texts are empty. */
MULTUM_API multum_parameter multum_parameter_at(const char* command, int index);

/* ---------------------------------------------------------------------------------------------------- devices -- */

typedef struct multum_device multum_device;

/* Opens an OpenCL device. If `selector` is NULL or "", opens the first GPU, or the first CPU if there is no GPU.
 * Otherwise, `selector` is a number from multum_list_devices(), or a part of the name of a device or platform. The
 * first call in a process takes 0.1 to 1 s, because the driver must be loaded. */
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

/* An image in memory. Rows are stored from the top, and channels are interleaved. */
typedef struct multum_image {
  size_t size;
  int width, height; /* texels, at least 1 */
  int channels;      /* 1 to 4: grey; grey, alpha; red, green, blue; red, green, blue, alpha */
  multum_type type;
  ptrdiff_t row_bytes; /* distance from one row to the next; 0 if there are no gaps between rows */
  const void* pixels;  /* the first row; must stay unchanged during the call */
} multum_image;
#define MULTUM_IMAGE_INIT \
  { sizeof(multum_image), 0, 0, 0, MULTUM_UINT8, 0, NULL }

/* The maps of a material, which are files or images in memory. Normals are required, and all other maps are optional.
 * The normals can be the file `input` or an image. The files of the other maps are given by the settings "albedo",
 * "roughness" and "weights". Files are decoded in a child process, so a broken file cannot crash the caller. Images in
 * memory need no child process. */
typedef struct multum_maps {
  size_t size;
  const char* input; /* a normal map or a height field; NULL if `normals` is given */
  const multum_image *normals, *albedo, *roughness, *weights;
} multum_maps;
#define MULTUM_MAPS_INIT \
  { sizeof(multum_maps), NULL, NULL, NULL, NULL, NULL }

typedef struct multum_map multum_map;

/* Bakes a mipmap of distributions of normals. For equal settings and pixels, the texels equal those of `multum bake`.
 * `values` holds settings of "bake"; NULL means the defaults. `output` is the file to write, which appears complete or
 * not at all. If `output` is NULL, the result is kept in a temporary file that multum_map_free() removes. `map` may be
 * NULL if `output` is given. */
MULTUM_API multum_status multum_bake(multum_device* device, const multum_maps* maps, const multum_values* values,
                                     const char* output, const multum_callbacks* callbacks, multum_map** map,
                                     multum_error** error);

/* Exports a map as a material with one lobe per texel, like `multum export`. `output` is a folder, NAME.ktx2 or
 * NAME.dds. `report` may be NULL. Otherwise it receives the JSON that `multum export --report` writes. */
MULTUM_API multum_status multum_export(multum_device* device, const multum_maps* maps, const multum_values* values,
                                       const char* output, const multum_callbacks* callbacks, multum_text** report,
                                       multum_error** error);

/* Writes a copy of a glTF model whose textures have fitted mips, like `multum gltf`. `input` is *.glb, or *.gltf with
 * its files. `output` is *.glb. `values` holds settings of "gltf", or is NULL. `report` may be NULL. Otherwise it
 * receives the JSON that `multum gltf --report` writes. */
MULTUM_API multum_status multum_convert_model(multum_device* device, const char* input, const multum_values* values,
                                              const char* output, const multum_callbacks* callbacks,
                                              multum_text** report, multum_error** error);

/* Measures the error of a baked file against the maps from which it was baked, in the same way as the bake did.
 * `values` must be the settings of the bake. Returns MULTUM_NOT_VERIFIED if the file is damaged. `errors` receives a
 * JSON array of the form of multum_map_text(map, "measured_error"). */
MULTUM_API multum_status multum_measure(multum_device* device, const char* baked, const multum_maps* maps,
                                        const multum_values* values, const multum_callbacks* callbacks,
                                        multum_text** errors, multum_error** error);

/* ------------------------------------------------------------------------------------------------ baked maps -- */

typedef struct multum_info {
  int width, height;        /* size of level 0 */
  int level_count;          /* number of levels down to 1 x 1 */
  int first_level;          /* the finest stored level */
  int lobe_count;           /* 0 if texels are not lobes */
  int sh_order;             /* order of spherical harmonics; 0 for other maps */
  int has_colours;          /* 0 or 1 */
  int weight_count;         /* number of weights of basis BRDFs, 0 to 4 */
  int repeats_s, repeats_t; /* 1 if the map repeats along u or v; 0 if it ends at its border */
} multum_info;

/* The parts of a texel. The values of a level are a float array [layer][row][column][channel]. */
typedef enum multum_part {
  MULTUM_LOBES = 0,        /* one layer per lobe: (a r_x, a r_y, a r_z, a); amplitude a, mean vector r, |r| <= 1 */
  MULTUM_COLOURS = 1,      /* linear RGB; for lobes, one layer per lobe, multiplied by a */
  MULTUM_WEIGHTS = 2,      /* weights of basis BRDFs; for lobes, one layer per lobe, multiplied by a */
  MULTUM_SLOPES = 3,       /* moments of slopes: height, E[s], E[t], E[s^2], E[t^2], E[s t] */
  MULTUM_MEAN_NORMALS = 4, /* mean normal, |n| <= 1; stored with the moments */
  MULTUM_HARMONICS = 5     /* one layer per four coefficients of spherical harmonics */
} multum_part;

/* Opens a baked file. This reads only the header. */
MULTUM_API multum_status multum_map_open(const char* path, multum_map** map, multum_error** error);
MULTUM_API void multum_map_free(multum_map* map);
MULTUM_API multum_info multum_map_info(const multum_map* map);
/* Returns a text of the header. The keys are "representation" (vmf, gmm, moments or sh), "encoding" (snorm16, half or
 * float), "content_hash", "source_name", "source_hash", "settings", "measured_error", "reading" and "software". The key
 * "report" gives the JSON report of the bake that made this object. Returns "" for other keys and for texts that the
 * file lacks. The text is valid until the map is freed. */
MULTUM_API const char* multum_map_text(multum_map* map, const char* key);
/* Writes a copy of the file. The copy appears complete or not at all. */
MULTUM_API multum_status multum_map_save(multum_map* map, const char* path, multum_error** error);

/* The values of one part of one level. They belong to the map, and are read at the first call. They remain valid until
 * multum_map_forget() or multum_map_free() is called. */
typedef struct multum_view {
  const float* values; /* [layer][row][column][channel] */
  int layers, height, width, channels;
} multum_view;
MULTUM_API multum_status multum_map_level(multum_map* map, int level, multum_part part, multum_view* view,
                                          multum_error** error);
/* Frees the levels that the map keeps in memory. */
MULTUM_API void multum_map_forget(multum_map* map);

/* Copies a region of a level, but does not keep it in memory. The region has the columns x to x + width - 1 of the rows
 * y to y + height - 1. Reads only the rows of tiles that hold the region. `type` is MULTUM_FLOAT or MULTUM_HALF, or
 * MULTUM_SNORM16 for files with encoding snorm16. `values` needs room for layers * height * width * channels values.
 * multum_map_shape() returns the numbers of layers and channels. */
typedef struct multum_region {
  int x, y, width, height;
} multum_region;
MULTUM_API multum_status multum_map_read(multum_map* map, int level, multum_part part, multum_region region,
                                         multum_type type, void* values, multum_error** error);
/* Returns the shape of a part of a level. The member `values` is NULL. All counts are 0 if the map has no such part or
 * level. */
MULTUM_API multum_view multum_map_shape(const multum_map* map, int level, multum_part part);

/* --------------------------------------------------------------------------------------------------- shading -- */

#define MULTUM_LOBES_MAX 8

/* The lobes of one texel, or of a filtered lookup. Only maps with representation vmf have such lobes. */
typedef struct multum_lobes {
  int count;
  int has_colours;
  float mean_cosine;                  /* 0, or the mean cosine of the roughness that the lobes contain */
  float lobes[MULTUM_LOBES_MAX][4];   /* (a r_x, a r_y, a r_z, a) */
  float colours[MULTUM_LOBES_MAX][3]; /* a * linear RGB; set only if has_colours is 1 */
} multum_lobes;

/* Filters the lobes at texture coordinates (u, v) linearly within levels and between levels, as graphics hardware does.
 * v = 0 is the top of the image. `level` is the level of detail, where 0 is the finest level. It is clamped to the
 * stored levels. The levels that are needed are loaded and kept, so later calls take less than a microsecond. */
MULTUM_API multum_status multum_map_lookup(multum_map* map, double u, double v, double level, multum_lobes* lobes,
                                           multum_error** error);

typedef struct multum_brdf multum_brdf;

/* Makes a BRDF from a text such as "lambert", "blinn-phong:100", "ggx:0.4" or "ggx:0.4,0.04" (roughness, F0).
 * docs/reference/commands.md lists all forms. The text can also be the file of a measured BRDF. Fits the vMF terms of
 * the BRDF, which takes a few milliseconds. */
MULTUM_API multum_status multum_brdf_new(const char* text, multum_brdf** brdf, multum_error** error);
MULTUM_API void multum_brdf_free(multum_brdf* brdf);

/* Computes the light that a texel reflects from the direction `light` towards `view`, in linear RGB. This is the
 * integral of BRDF * max(n . light, 0) over the normals n of the texel. The light has irradiance 1 on a surface
 * perpendicular to its direction. The formulas are those of the GL runtime, in double precision. Only GGX differs,
 * whose facets are a sum of four vMFs here. The colours of `lobes` multiply the diffuse part. Without colours, the
 * BRDF's own albedo is used. If the map was baked with roughness (mean_cosine above 0), the lobes contain the width of
 * the highlight, and only the colours and the Fresnel term of the BRDF are used. The result is 0 if `light` or `view`
 * points below the horizon. */
MULTUM_API void multum_shade(const multum_lobes* lobes, const multum_brdf* brdf, const double light[3],
                             const double view[3], double rgb[3]);

/* Returns the density of normals at `normal`, per steradian. The integral of the density is the sum of the
 * amplitudes. */
MULTUM_API double multum_density(const multum_lobes* lobes, const double normal[3]);

/* Draws a light direction with a density proportional to an approximation of multum_shade() for this `view`. `random`
 * holds three numbers in [0, 1). Stores the direction in `light` and returns its density per steradian. The direction
 * may point below the horizon, where multum_shade() is 0. Returns 0 if there is nothing to sample. */
MULTUM_API double multum_sample(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3],
                                const double random[3], double light[3]);
/* Returns the density with which multum_sample() draws `light`, per steradian. */
MULTUM_API double multum_pdf(const multum_lobes* lobes, const multum_brdf* brdf, const double view[3],
                             const double light[3]);

/* The view of a plane that is covered with a map. The plane is z = 0. One tile of the map covers 0 <= x <= 1 and
 * 0 <= y <= 1, and the first row of the map is at y = 1. */
typedef struct multum_plane {
  size_t size;
  double eye[3], target[3]; /* place of the camera, above the plane, and a point in the middle of its picture */
  double fov;               /* vertical angle of view in degrees */
  double light[3];          /* unit vector to a distant light, which has irradiance 1 on a surface that faces it */
  int width, height;        /* pixels */
  int taps;                 /* largest number of lookups per pixel, along the longer side of its footprint */
} multum_plane;
#define MULTUM_PLANE_INIT \
  { sizeof(multum_plane), {0.5, -0.7, 0.7}, {0.5, 0.5, 0.0}, 40.0, {0.0, 0.0, 1.0}, 256, 256, 4 }

/* Draws the plane with the formulas of the GL runtime, in single precision, on the OpenCL device. `rgba` needs room for
 * height * width * 4 values, and receives linear RGB and the coverage (0 or 1), [row][column][channel]. Only maps with
 * representation vmf can be drawn. The levels that the picture needs are loaded and kept in the map. */
MULTUM_API multum_status multum_render_plane(multum_device* device, multum_map* map, const multum_brdf* brdf,
                                             const multum_plane* plane, const multum_callbacks* callbacks, float* rgba,
                                             multum_error** error);

/* ---------------------------------------------------------------------------------------------------- fields -- */

/* A field consists of textures that are inferred from ray-traced pictures. The textures depend on parameters, such as
 * the place of the view and of the light (Hakura et al. 2000). If the library was built without fields, the functions
 * of this section return MULTUM_BAD_ENVIRONMENT. */

/* Infers the textures of a job, like `multum infer`. `job` is a job file (docs/reference/animation_jobs.md), and
 * `output` is a folder. `values` holds settings of "infer", or is NULL. `report` may be NULL. Otherwise it receives the
 * JSON of report.json. Draws frames by multum-view, which must be installed next to the library or be in PATH. */
MULTUM_API multum_status multum_infer(multum_device* device, const char* job, const multum_values* values,
                                      const char* output, const multum_callbacks* callbacks, multum_text** report,
                                      multum_error** error);

/* Compresses the folder that multum_infer() wrote into one file, *.mpt, like `multum pack`. `values` holds settings of
 * "pack", or is NULL. `report` may be NULL. Otherwise it receives the JSON that `multum pack --json` prints. */
MULTUM_API multum_status multum_pack(multum_device* device, const char* folder, const multum_values* values,
                                     const char* output, const multum_callbacks* callbacks, multum_text** report,
                                     multum_error** error);

/* Publishes a packed field with its player for browsers, like `multum player`. `output` is a folder for a static web
 * server, or a single page, *.html. */
MULTUM_API multum_status multum_publish_field(const char* packed, const char* output, multum_error** error);

typedef struct multum_field multum_field;

/* Opens a packed field. This reads only the description and the index. */
MULTUM_API multum_status multum_field_open(const char* path, multum_field** field, multum_error** error);
MULTUM_API void multum_field_free(multum_field* field);
/* Returns the description of the field as JSON: "parameters" (names), "sizes" (number of samples along each parameter),
 * "width" and "height" of a frame in pixels, "objects", "layers" ("object" and "name" of each) and more. The text is
 * valid until the field is freed. */
MULTUM_API const char* multum_field_text(const multum_field* field);

/* Decodes one texture. `layer` is the index of an entry of "layers". `point` has one number per parameter, which is an
 * index along the samples of the parameter, such as 3.4. The nearest sample is decoded; numbers beyond the samples are
 * clamped. If `rgb` is NULL, only `shape` is set, and all its counts are 0 if the layer is invisible in this sample.
 * Otherwise `rgb` needs room for height * width * 3 values, and receives the linear radiance [row][column][channel] of
 * the finest level. */
MULTUM_API multum_status multum_field_texture(multum_field* field, int layer, const double* point, multum_view* shape,
                                              float* rgb, multum_error** error);

/* Draws `count` frames. `points` holds one point per frame, [frame][parameter], with numbers as for
 * multum_field_texture(). Cameras and objects move continuously between samples. Textures are those of the nearest
 * sample, or are interpolated linearly if `is_linear` is not 0. `rgba` needs room for count * height * width * 4
 * values, and receives linear radiance and the share of each pixel that objects cover, [frame][row][column][channel].
 * Draws by multum-view, as multum_infer() does. Returns MULTUM_BAD_INPUT if a part that the frames need is damaged. */
MULTUM_API multum_status multum_field_play(multum_field* field, const double* points, int count, int is_linear,
                                           const multum_callbacks* callbacks, float* rgba, multum_error** error);

#ifdef __cplusplus
}
#endif

#endif
