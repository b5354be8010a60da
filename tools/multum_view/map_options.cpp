// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/map_options.h"

#include <fmt/format.h>

#include <utility>

#include "host/foundation/base/error.h"
#include "tools/command_line/choices.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

void add_source_options(CLI::App& app, SourceOptions& options) {
  app.add_option(
      "--source", options.normals,
      "normal map that the file was baked from, for the reference and the baselines (default: level 0 of the "
      "file) and, in files baked with --first-level, for the finest levels");
  app.add_option("--albedo", options.albedo, "the source's colours");
  CLI::Option* const roughness = app.add_option("--roughness", options.roughness,
                                                "the source's roughness, FILE or FILE:CHANNEL, as the bake had it");
  app.add_option("--gloss", options.gloss, "the same of a gloss map, roughness = 1 - gloss")->excludes(roughness);
  app.add_option("--weights", options.weights, "the source's weights of basis BRDFs");
}

void add_comparison_options(CLI::App& app, ComparisonOptions& options) {
  app.add_option_function<std::string>(
      "--compare", [&options](const std::string& text) { options.pictures = parse_compared("--compare", text); },
      "also draw these beside it, of reference,mip,toksvig,lean,lean-jacobian; with reference: errors too. points: "
      "mip, "
      "shaded at as many points of each pixel as the map takes evaluations; toksvig-points, lean-points, "
      "lean-jacobian-points: the same");
  CLI::Option* const samples =
      app.add_option("--samples", options.sampling.sample_count,
                     "samples per pixel of the reference (default: as many as --reference-noise takes)")
          ->check(CLI::Range(1, gl::kReferenceSampleCountMax));
  app.add_option("--reference-noise", options.sampling.noise_max,
                 "draw the reference until its noise, in relative L1, is at most this; seconds in software, with a "
                 "progress bar")
      ->check(number_in(1e-5f, 1.0f))
      ->capture_default_str()
      ->excludes(samples);
  add_choice(app, "--pixel-filter", options.sampling.filter, kPixelFilters,
             "how the reference weighs what lies around a pixel's middle: box (its own area), tent (2 pixels wide) or "
             "gaussian (standard deviation 1/2 pixel)")
      ->default_str("box");
  CLI::Option* const texels =
      add_choice(app, "--reference-texels", options.reference, kReferenceTexels,
                 "between the middles of the finest texels the reference has the nearest one, a blend of the light of "
                 "the four around, or their interpolated normal: nearest, blended or interpolated")
          ->default_str("nearest");
  app.add_option_function<std::string>(
         "--reference-of",
         [&options](const std::string& text) {
           if (text == "texels") options.reference = gl::NormalMaterial::Sampling::kFootprint;
         },
         "average the reference over the pixel, or over the texels that the filter takes there, so that the error is "
         "that of the baked texels alone")
      ->check(CLI::IsMember({"pixel", "texels"}))
      ->excludes(texels)
      ->default_str("pixel");
  app.add_option("--keep-reference", options.kept_reference,
                 "file that the reference is kept in: where it is there, the reference is read from it and not drawn, "
                 "for other bakes of the same map with the same view, BRDF and lights");
}

}  // namespace

void add_map_options(CLI::App& app, MapOptions& options) {
  PictureOptions& picture = options.picture;
  add_comparison_options(app, options.comparison);
  add_source_options(app, options.source);
  app.add_flag("--stored-only", options.stored_only,
               "draw the finest level of a file baked with --first-level where a finer one is asked for, without "
               "--source");
  add_mesh_option(app, picture.surface);
  add_repeat_option(app, picture.surface);
  add_camera_options(app, picture.camera);
  add_rendering_options(app, picture);
  app.add_option(
      "--brdf-roughness", options.brdf_roughness,
      "roughness map of --brdf ggx, FILE or FILE:CHANNEL, of the map's size, times its ROUGHNESS as in glTF; "
      "of lobes under lights, with --compare reference and mip");
  app.add_option("--shaders", options.shaders,
                 "write the shader variants that were drawn with as JSON: flags, text, and the uniforms that the "
                 "driver kept");
  add_parameter_options(app, options.source.reading,
                        {"bumpformat", "green", "signed", "unsigned", "two_channel", "z_range", "height_scale",
                         "dequantize", "normal_scale", "fixnan", "repair_max"},
                        false);
  add_decoding_option(app);
}

void add_pictures_option(CLI::App& app, OutputOptions& options) {
  app.add_option("--pictures", options.pictures,
                 "also write each picture by itself: PREFIX_multum.png, PREFIX_reference.png, "
                 "PREFIX_multum_difference.png, ...");
}

void add_alone_option(CLI::App& app, OutputOptions& options) {
  app.add_flag(
      "--alone", options.is_alone,
      "with --compare: write the baked map's picture alone to -o; the others are drawn, measured and not shown");
}

void add_animation_options(CLI::App& app, AnimationOptions& options) {
  app.add_option("--frames", options.frame_count, "number of frames")
      ->check(CLI::Range(2, 9999))
      ->capture_default_str();
  app.add_option_function<std::string>(
      "--to-camera", [&](const std::string& text) { options.camera = parse_camera("--to-camera", text); },
      "--camera of the last frame");
  app.add_option_function<std::vector<std::string>>(
      "--to-light",
      [&](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) options.lights.push_back(parse_light("--to-light", text));
      },
      "--light of the last frame, as often as --light");
  app.add_option_function<std::vector<std::string>>(
      "--to-point-light",
      [&](const std::vector<std::string>& texts) {
        for (const std::string& text : texts)
          options.point_lights.push_back(parse_point_light("--to-point-light", text));
      },
      "--point-light of the last frame, as often as --point-light");
  app.add_option("--to-environment", options.environment,
                 "environment that --environment fades into, of its size; its harmonics and filtered levels change "
                 "from frame to frame");
  app.add_option("--to-environment-turn", options.environment_turn, "--environment-turn of the last frame")
      ->check(number_in(-3600.0f, 3600.0f));
  app.add_option("--to-brdf", options.brdf, "--brdf of the last frame, of the same family");
  app.add_option_function<std::string>(
      "--to-diffuse", [&](const std::string& text) { options.diffuse = parse_colour("--to-diffuse", text); },
      "--diffuse of the last frame");
  app.add_option_function<std::string>(
      "--to-specular", [&](const std::string& text) { options.specular = parse_colour("--to-specular", text); },
      "--specular of the last frame");
}

namespace {

/// What knows one roughness for all of a picture.
void check_brdf_roughness(const MapOptions& options) {
  const PictureOptions& picture = options.picture;
  const auto refuse = [](const std::string& found, const char* expected) {
    throw Error(ErrorCode::kUsage, fmt::format("--brdf-roughness: found {}, expected {}", found, expected));
  };
  const std::vector<std::string>& brdfs = picture.material.brdfs;
  if (brdfs.size() != 1 || !brdfs[0].starts_with("ggx:"))
    refuse(brdfs.empty() ? "no --brdf" : "--brdf " + brdfs[0], "--brdf ggx:ROUGHNESS");
  if (!picture.light.environment.empty()) refuse("--environment", "lights");
  for (const std::string& one : options.comparison.pictures)
    if (one != "reference" && one != "mip") refuse("--compare " + one, "reference and mip, which know GGX");
}

}  // namespace

void check_map_options(const MapOptions& options) {
  const PictureOptions& picture = options.picture;
  const SourceOptions& source = options.source;
  if (!picture.camera.distances.empty() && picture.surface.mesh.empty())
    throw Error(ErrorCode::kUsage, "--distance: goes with a mesh, found no --mesh");
  if (options.comparison.is_of_texels() && picture.shading.filter.is_drivers)
    throw Error(ErrorCode::kUsage,
                "--reference-of texels: averages what --taps and --level-bias look up; found --anisotropy, the "
                "driver's own filter, expected none");
  for (const auto& [option, path] : {std::pair{"--albedo", &source.albedo}, std::pair{"--roughness", &source.roughness},
                                     std::pair{"--gloss", &source.gloss}, std::pair{"--weights", &source.weights}})
    if (!path->empty() && source.normals.empty())
      throw Error(ErrorCode::kUsage,
                  fmt::format("{} goes with --source: both describe the map that the file was baked from", option));
  if (!options.brdf_roughness.empty()) check_brdf_roughness(options);
  if (!options.comparison.kept_reference.empty() &&
      (!options.animation.folder.empty() || !picture.camera.distances.empty() || options.comparison.is_of_texels()))
    throw Error(ErrorCode::kUsage,
                "--keep-reference: found several views or --reference-of texels, expected one view, whose reference is "
                "of the pixel");
  const AnimationOptions& to = options.animation;
  if (picture.light.environment.empty() &&
      (picture.light.environment_turn || to.environment_turn || !to.environment.empty()))
    throw Error(ErrorCode::kUsage,
                "--environment-turn, --to-environment and --to-environment-turn: found no --environment, expected one");
  const bool has_frames = !options.animation.folder.empty();
  if (has_frames != options.animation.changes_anything())
    throw Error(ErrorCode::kUsage, has_frames ? "animate: say what changes: --to-camera, --to-light, --to-brdf, ..."
                                              : "--to-camera, --to-light and the like go with multum-view animate");
  if (!has_frames) check_picture_path(picture.output.path);
}

}  // namespace multum
