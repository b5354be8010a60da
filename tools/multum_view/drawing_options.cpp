// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/drawing_options.h"

#include <fmt/format.h>

#include "host/foundation/brdf_families/brdf_forms.h"
#include "tools/command_line/choices.h"

namespace multum {
namespace {

template <typename Value, typename Parse>
CLI::Option* add_parsed(CLI::App& app, const std::string& option, Value& value, Parse parse, const std::string& help) {
  return app.add_option_function<std::string>(
      option, [option, &value, parse](const std::string& text) { value = parse(option, text); }, help);
}

template <typename Value, typename Parse>
CLI::Option* add_parsed_list(CLI::App& app, const std::string& option, std::vector<Value>& values, Parse parse,
                             const std::string& help) {
  return app.add_option_function<std::vector<std::string>>(
      option,
      [option, &values, parse](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) values.push_back(parse(option, text));
      },
      help);
}

void add_environment_options(CLI::App& app, LightOptions& options) {
  app.add_option("--environment", options.environment,
                 "environment light, also shown as the background: a latitude-longitude image, .exr or .hdr");
  app.add_option("--environment-turn", options.environment_turn,
                 "rotate the environment about the up axis by this many degrees, counterclockwise seen from above")
      ->check(number_in(-3600.0f, 3600.0f));
  app.add_flag("--no-background", options.no_background, "draw black behind the surface instead of the environment");
  add_choice(app, "--environment-mode", options.environment_mode, kEnvironmentModes,
             "highlights of the environment: prefiltered (mips convolved with vMFs) or sh (harmonics to order 8, for "
             "broad BRDFs)")
      ->default_str("prefiltered");
}

void add_shading_options(CLI::App& app, ShadingOptions& options) {
  add_choice(app, "--formula", options.formula, kLobeFormulas,
             "how to combine lobe and BRDF: product (of mean cosines) or paper (Han 2007, eq. 20)");
  app.add_flag("--shade-first", options.shade_first,
               "shade the lobes of all eight texels of a trilinear footprint, then mix; slow, and needed for bakes "
               "with --unaligned");
  add_choice(app, "--surface", options.surface, kMapSurfaces,
             "where lobes of level 0 are magnified, blend the light of the nearest texels (texels), or show the normal "
             "map's interpolated surface as engines do (interpolated)")
      ->default_str("as in --reference-texels, else texels");
  add_choice(app, "--moments", options.moments, kMomentShadings,
             "shade a file of moments by toksvig, lean or lean-jacobian (default: lean-jacobian)");
  app.add_option("--colour-map", options.colour_map,
                 "colours for a file of lobes without colours: a pyramid of multum mip, such as a scene's bake writes");
}

void add_filter_options(CLI::App& app, ShadingOptions& options) {
  CLI::Option* const taps =
      app.add_option("--taps", options.filter.taps,
                     "most trilinear lookups of every texture along a pixel's longer axis; 1: a single lookup")
          ->check(CLI::Range(1, kTapCountMax))
          ->capture_default_str();
  CLI::Option* const bias =
      add_level_bias_option(app, options.level_bias, "number added to the mip level of each lookup; below 0 is sharper")
          ->default_str(fmt::format("{:g}", kLevelBiasDefault));
  CLI::Option* const shade = app.add_flag("--shade-taps,!--no-shade-taps", options.filter.shades_taps,
                                          "shade each of the --taps lookups, then average; --no-shade-taps: average "
                                          "the lookups, then shade once (default)");
  CLI::Option* const evaluations =
      app.add_option_function<int>(
             "--evaluations", [&options](const int& count) { options.evaluations = count; },
             "shading evaluations per pixel, 1, 2, 4, 8 or 16: at points where normals are similar, else of lobes; 0: "
             "each lobe once (default: the number of lobes, rounded up to a power of two; 0 with --shade-taps, "
             "--shade-first, --formula paper and files without vMF lobes)")
          ->check(CLI::IsMember({0, 1, 2, 4, 8, 16}))
          ->excludes(shade);
  app.add_option_function<float>(
         "--anisotropy",
         [&options](const float& anisotropy) {
           options.anisotropy = anisotropy;
           options.filter.is_drivers = true;
         },
         "let the driver filter, with this anisotropy; drivers differ")
      ->check(number_in(1.0f, 16.0f))
      ->excludes(taps)
      ->excludes(bias)
      ->excludes(shade)
      ->excludes(evaluations);
}

}  // namespace

void add_mesh_option(CLI::App& app, SurfaceOptions& options) {
  app.add_option("--mesh", options.mesh,
                 "OBJ, glTF or GLB that gets the map (default: a plane z = 0 that reaches the horizon: x from -30 to "
                 "30, y from 0 to 60)");
}

void add_repeat_option(CLI::App& app, SurfaceOptions& options) {
  app.add_option("--repeat", options.repeat,
                 "repeats of the map across the plane or uv unit (default: 60; 1 with a mesh)")
      ->check(number_in(1e-6f, 1e6f));
}

void add_camera_options(CLI::App& app, CameraOptions& options) {
  add_parsed(app, "--camera", options.place, parse_camera,
             "eye and target: x,y,z,x,y,z[,field of view in degrees] (default: 0,0,0.3,0,1,-0.0939 for the plane; a "
             "view of the whole mesh)");
  add_parsed(app, "--up", options.up, parse_up,
             "up direction of the picture, x,y,z (default: 0,0,1; with a mesh 0,1,0)");
}

void add_distance_option(CLI::App& app, CameraOptions& options) {
  add_parsed(app, "--distance", options.distances, parse_distances,
             "draw the mesh from several distances, a list of factors of the camera's distance; 1,5,25 with -o "
             "NAME.png writes NAME_1.png, NAME_5.png and NAME_25.png");
}

void add_light_options(CLI::App& app, LightOptions& options) {
  add_parsed_list(app, "--light", options.distant, parse_light,
                  "direction towards a distant light: x,y,z[,irradiance]; up to 8 times");
  add_parsed_list(app, "--point-light", options.points, parse_point_light,
                  "position and intensity of a point light: x,y,z,i or x,y,z,r,g,b; up to 8 times");
}

void add_material_options(CLI::App& app, MaterialOptions& options) {
  using CLI::MultiOptionPolicy;
  app.add_option("--brdf", options.brdfs,
                 brdf_forms("", true) +
                     ", or the file of a measured BRDF (.brdf text, .binary of MERL, .json of a fit); several times: "
                     "basis BRDFs that the file's weights blend; a file baked with roughness has its own BRDF "
                     "(default: blinn-phong:100)")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  app.add_option("--brdf-terms", options.term_count,
                 "number of vMF densities that approximate measured facets over lobes and, under an environment, all "
                 "facets that one density fits badly; more is more accurate and slower")
      ->check(CLI::Range(1, kBrdfTermCountMax))
      ->capture_default_str();
  add_parsed_list(
      app, "--diffuse", options.diffuse, parse_colour,
      "diffuse reflectance, grey or r,g,b (default: 0.5, or the measured one); several times: one for each --brdf")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  add_parsed_list(app, "--specular", options.specular, parse_colour,
                  "specular factor, grey or r,g,b (default: 0.1; 1 if the BRDF has Fresnel or is measured); several "
                  "times: one for each --brdf")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  add_parsed(app, "--fixed-fresnel", options.fixed_fresnel, parse_colour,
             "replace the BRDF's Fresnel term at every angle by this number, grey or r,g,b; a scene's plan may set it "
             "too. The shader then leaves out the term's code");
}

CLI::Option* add_picture_option(CLI::App& app, OutputOptions& options) {
  return app.add_option("-o,--output", options.path, "picture to write: .png (sRGB) or .exr (linear floats)");
}

void add_output_options(CLI::App& app, OutputOptions& options) {
  add_parsed(app, "--size", options.size, parse_size, "size of each picture in pixels")->default_str("640x480");
  app.add_option("--exposure", options.exposure, "brightness of a PNG")
      ->check(number_in(1e-6f, 1e6f))
      ->capture_default_str();
  app.add_option("--report", options.report, "write errors, times and settings as JSON");
}

CLI::Option* add_level_bias_option(CLI::App& app, std::optional<float>& bias, const std::string& help) {
  return app.add_option("--level-bias", bias, help)->check(number_in(-16.0f, 16.0f));
}

void add_context_option(CLI::App& app, gl::ContextBackend& context) {
  add_choice(app, "--context", context, kContextBackends, "GL to draw with: auto, osmesa (software) or egl");
}

void add_rendering_options(CLI::App& app, PictureOptions& options) {
  add_light_options(app, options.light);
  add_environment_options(app, options.light);
  add_material_options(app, options.material);
  add_shading_options(app, options.shading);
  add_filter_options(app, options.shading);
  add_output_options(app, options.output);
  add_context_option(app, options.context);
}

}  // namespace multum
