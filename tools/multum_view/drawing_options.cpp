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
                 "light the scene with this latitude-longitude image, .exr or .hdr, also as its background");
  app.add_option("--environment-turn", options.environment_turn,
                 "rotate the environment by this many degrees about the up axis, counterclockwise when seen from above")
      ->check(number_in(-3600.0f, 3600.0f));
  app.add_flag("--no-background", options.no_background, "draw a black background instead of the environment");
  add_choice(app, "--environment-mode", options.environment_mode, kEnvironmentModes,
             "shade highlights of the environment by mips convolved with vMFs (prefiltered) or by harmonics up to "
             "order 8 (sh), for broad BRDFs and harmonics")
      ->default_str("prefiltered");
}

void add_shading_options(CLI::App& app, ShadingOptions& options) {
  add_choice(
      app, "--formula", options.formula, kLobeFormulas,
      "combine lobe and BRDF by the product of mean cosines (product), or as in Han et al. 2007, eq. 20 (paper)");
  app.add_flag("--shade-first", options.shade_first,
               "shade the lobes of all eight texels of a trilinear lookup, and then mix the light; slow, but correct "
               "for --unaligned bakes");
  add_choice(
      app, "--surface", options.surface, kMapSurfaces,
      "in near views of level 0, blend the light of the texels (texels), or interpolate the normal map as engines do "
      "(interpolated)")
      ->default_str("the value of --reference-texels, else texels");
  add_choice(app, "--moments", options.moments, kMomentShadings,
             "shade a file of moments by this method (default: lean-jacobian); under --environment, all methods draw "
             "like toksvig");
  app.add_option("--colour-map", options.colour_map,
                 "read colours for a file without colours from this pyramid of `multum mip`");
}

void add_filter_options(CLI::App& app, ShadingOptions& options) {
  CLI::Option* const taps =
      app.add_option("--taps", options.filter.taps,
                     "take at most this many trilinear texture lookups along the longer axis of a pixel")
          ->check(CLI::Range(1, kTapCountMax))
          ->capture_default_str();
  CLI::Option* const bias =
      add_level_bias_option(app, options.level_bias, "add this to the mip level; negative values make pictures sharper")
          ->default_str(fmt::format("{:g}", kLevelBiasDefault));
  CLI::Option* const shade =
      app.add_flag("--shade-taps,!--no-shade-taps", options.filter.shades_taps,
                   "shade each lookup of --taps and average the light; --no-shade-taps, the default, averages the "
                   "lookups and shades once, which is faster and less accurate");
  CLI::Option* const evaluations =
      app.add_option_function<int>(
             "--evaluations", [&options](const int& count) { options.evaluations = count; },
             "evaluate the light of the map this many times per pixel; 0 means once per lobe (default: the number of "
             "lobes, rounded up to a power of two)")
          ->check(CLI::IsMember({0, 1, 2, 4, 8, 16}))
          ->excludes(shade);
  app.add_option_function<float>(
         "--anisotropy",
         [&options](const float& anisotropy) {
           options.anisotropy = anisotropy;
           options.filter.is_drivers = true;
         },
         "let the driver filter the textures with this anisotropy; the result depends on the driver")
      ->check(number_in(1.0f, 16.0f))
      ->excludes(taps)
      ->excludes(bias)
      ->excludes(shade)
      ->excludes(evaluations);
}

}  // namespace

void add_mesh_option(CLI::App& app, SurfaceOptions& options) {
  app.add_option(
      "--mesh", options.mesh,
      "draw the map on this OBJ, glTF or GLB mesh (default: a plane z = 0 up to the horizon, x from -30 to 30, "
      "y from 0 to 60)");
}

void add_repeat_option(CLI::App& app, SurfaceOptions& options) {
  app.add_option("--repeat", options.repeat,
                 "repeat the map this many times across the plane, or per unit of texture coordinates on a mesh "
                 "(default: 60, or 1 on a mesh)")
      ->check(number_in(1e-6f, 1e6f));
}

void add_camera_options(CLI::App& app, CameraOptions& options) {
  add_parsed(app, "--camera", options.place, parse_camera,
             "set the eye and the target: x,y,z,x,y,z[,field of view in degrees] (default: 0,0,0.3,0,1,-0.0939; on a "
             "mesh, the whole mesh)");
  add_parsed(app, "--up", options.up, parse_up,
             "set the up direction of the picture, x,y,z (default: 0,0,1, or 0,1,0 on a mesh)");
}

void add_distance_option(CLI::App& app, CameraOptions& options) {
  add_parsed(app, "--distance", options.distances, parse_distances,
             "draw the mesh at these relative distances; 1,5,25 with -o NAME.png writes NAME_1.png, NAME_5.png and "
             "NAME_25.png");
}

void add_light_options(CLI::App& app, LightOptions& options) {
  add_parsed_list(app, "--light", options.distant, parse_light,
                  "add a distant light in the direction x,y,z[,irradiance]; can be repeated up to 8 times");
  add_parsed_list(
      app, "--point-light", options.points, parse_point_light,
      "add a point light by its position x,y,z and its intensity i or r,g,b; can be repeated up to 8 times");
}

void add_material_options(CLI::App& app, MaterialOptions& options) {
  using CLI::MultiOptionPolicy;
  app.add_option("--brdf", options.brdfs,
                 "shade with " + brdf_forms("", true) +
                     ", or a measured BRDF (.brdf text, MERL .binary, .json of a fit); give one per basis BRDF "
                     "(default: blinn-phong:100, or the roughness of the file)")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  app.add_option("--brdf-terms", options.term_count,
                 "approximate measured facets (under an environment, all facets) by a sum of this many vMF densities; "
                 "more densities lower the error but take longer")
      ->check(CLI::Range(1, kBrdfTermCountMax))
      ->capture_default_str();
  add_parsed_list(app, "--diffuse", options.diffuse, parse_colour,
                  "set the diffuse reflectance, a grey value or r,g,b (default: 0.5, or the measured reflectance); "
                  "give one per --brdf")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  add_parsed_list(app, "--specular", options.specular, parse_colour,
                  "set the specular factor, a grey value or r,g,b (default: 0.1, or 1 for measured BRDFs and BRDFs "
                  "with Fresnel); give one per --brdf")
      ->expected(1)
      ->multi_option_policy(MultiOptionPolicy::TakeAll);
  add_parsed(app, "--fixed-fresnel", options.fixed_fresnel, parse_colour,
             "replace the Fresnel term of the BRDF with this constant, a grey value or r,g,b, and omit the term from "
             "the shader");
}

CLI::Option* add_picture_option(CLI::App& app, OutputOptions& options) {
  return app.add_option("-o,--output", options.path, "picture to write: .png (sRGB) or .exr (linear floats)");
}

void add_output_options(CLI::App& app, OutputOptions& options) {
  add_parsed(app, "--size", options.size, parse_size, "set the size of each picture in pixels")->default_str("640x480");
  app.add_option("--exposure", options.exposure, "multiply the brightness of PNG pictures by this")
      ->check(number_in(1e-6f, 1e6f))
      ->capture_default_str();
  app.add_option("--report", options.report, "write errors, times and settings as JSON");
}

CLI::Option* add_level_bias_option(CLI::App& app, std::optional<float>& bias, const std::string& help) {
  return app.add_option("--level-bias", bias, help)->check(number_in(-16.0f, 16.0f));
}

void add_context_option(CLI::App& app, gl::ContextBackend& context) {
  add_choice(app, "--context", context, kContextBackends,
             "draw with this GL implementation: auto, osmesa (software) "
             "or egl");
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
