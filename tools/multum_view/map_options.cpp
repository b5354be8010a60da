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
  app.add_option("--source", options.normals,
                 "read the original normal map from this file, for the reference, the baselines and levels that are "
                 "not in the baked file (default: level 0 of the baked file)");
  app.add_option("--albedo", options.albedo, "read the colours of the source from this map");
  CLI::Option* const roughness = app.add_option(
      "--roughness", options.roughness, "read the roughness of the source from FILE or FILE:CHANNEL, as in the bake");
  app.add_option("--gloss", options.gloss, "read the gloss of the source from this map; roughness = 1 - gloss")
      ->excludes(roughness);
  app.add_option("--weights", options.weights, "read the weights of basis BRDFs of the source from this map");
}

void add_comparison_options(CLI::App& app, ComparisonOptions& options) {
  app.add_option_function<std::string>(
      "--compare", [&options](const std::string& text) { options.pictures = parse_compared("--compare", text); },
      "also draw these pictures: a list of reference, mip, toksvig, lean, lean-jacobian, points, toksvig-points, "
      "lean-points, lean-jacobian-points; with reference, print relative L1 errors");
  CLI::Option* const samples =
      app.add_option(
             "--samples", options.sampling.sample_count,
             "draw the reference with this many samples per pixel (default: as many as --reference-noise needs)")
          ->check(CLI::Range(1, gl::kReferenceSampleCountMax));
  app.add_option("--reference-noise", options.sampling.noise_max,
                 "add samples to the reference until its noise (relative L1) is at most this; software rendering is "
                 "slow")
      ->check(number_in(1e-5f, 1.0f))
      ->capture_default_str()
      ->excludes(samples);
  add_choice(app, "--pixel-filter", options.sampling.filter, kPixelFilters,
             "filter the pixels of the reference with a box (1 pixel), a tent (2 pixels wide) or a gaussian (standard "
             "deviation 1/2 pixel, cut off at 1.5)")
      ->default_str("box");
  CLI::Option* const texels =
      add_choice(app, "--reference-texels", options.reference, kReferenceTexels,
                 "between the centres of the finest texels, shade the reference with the nearest normal, with a blend "
                 "of the light of four texels, or with the interpolated normal")
          ->default_str("nearest");
  app.add_option_function<std::string>(
         "--reference-of",
         [&options](const std::string& text) {
           if (text == "texels") options.reference = gl::NormalMaterial::Sampling::kFootprint;
         },
         "average the reference over the pixel, or over the texels that the filter reads for the pixel, which excludes"
         " the error of the filter")
      ->check(CLI::IsMember({"pixel", "texels"}))
      ->excludes(texels)
      ->default_str("pixel");
  app.add_option("--keep-reference", options.kept_reference,
                 "read the reference from this file if it exists, else store it there; other bakes of the same map "
                 "with the same view, BRDF and lights can use the file");
}

}  // namespace

void add_map_options(CLI::App& app, MapOptions& options) {
  PictureOptions& picture = options.picture;
  add_comparison_options(app, options.comparison);
  add_source_options(app, options.source);
  app.add_flag("--stored-only", options.stored_only,
               "draw the finest stored level instead of finer levels that are not in the file; --source is then not "
               "needed");
  add_mesh_option(app, picture.surface);
  add_repeat_option(app, picture.surface);
  add_camera_options(app, picture.camera);
  add_rendering_options(app, picture);
  app.add_option(
      "--brdf-roughness", options.brdf_roughness,
      "multiply the ROUGHNESS of --brdf ggx by this map of the same size, FILE or FILE:CHANNEL; only for lobes under "
      "lights, with --compare reference or mip");
  app.add_option(
      "--shaders", options.shaders,
      "write the used shader variants as JSON: flags, source without #version, and uniforms that the driver kept");
  add_parameter_options(app, options.source.reading,
                        {"bumpformat", "green", "signed", "unsigned", "two_channel", "z_range", "height_scale",
                         "dequantize", "normal_scale", "fixnan", "repair_max"},
                        false);
  add_decoding_option(app);
}

void add_pictures_option(CLI::App& app, OutputOptions& options) {
  app.add_option("--pictures", options.pictures,
                 "also write each picture to its own file, PREFIX_multum.png, PREFIX_reference.png, "
                 "PREFIX_multum_difference.png and so on");
}

void add_alone_option(CLI::App& app, OutputOptions& options) {
  app.add_flag(
      "--alone", options.is_alone,
      "with --compare, write only the picture of the baked map to -o; the other pictures are drawn and measured, but "
      "not written");
}

void add_animation_options(CLI::App& app, AnimationOptions& options) {
  app.add_option("--frames", options.frame_count, "draw this many frames")
      ->check(CLI::Range(2, 9999))
      ->capture_default_str();
  app.add_option_function<std::string>(
      "--to-camera", [&](const std::string& text) { options.camera = parse_camera("--to-camera", text); },
      "set --camera of the last frame");
  app.add_option_function<std::vector<std::string>>(
      "--to-light",
      [&](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) options.lights.push_back(parse_light("--to-light", text));
      },
      "set --light of the last frame; give this option as often as --light");
  app.add_option_function<std::vector<std::string>>(
      "--to-point-light",
      [&](const std::vector<std::string>& texts) {
        for (const std::string& text : texts)
          options.point_lights.push_back(parse_point_light("--to-point-light", text));
      },
      "set --point-light of the last frame; give this option as often as --point-light");
  app.add_option(
      "--to-environment", options.environment,
      "change gradually from --environment to this environment of the same size; harmonics and filtered levels change "
      "in every frame");
  app.add_option("--to-environment-turn", options.environment_turn, "set --environment-turn of the last frame")
      ->check(number_in(-3600.0f, 3600.0f));
  app.add_option("--to-brdf", options.brdf, "set --brdf of the last frame; both BRDFs must belong to the same family");
  app.add_option_function<std::string>(
      "--to-diffuse", [&](const std::string& text) { options.diffuse = parse_colour("--to-diffuse", text); },
      "set --diffuse of the last frame");
  app.add_option_function<std::string>(
      "--to-specular", [&](const std::string& text) { options.specular = parse_colour("--to-specular", text); },
      "set --specular of the last frame");
}

namespace {

/// Throws Error(kUsage) for options that require a single roughness for the whole picture.
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
    if (one != "reference" && one != "mip") refuse("--compare " + one, "reference and mip, which support GGX");
}

}  // namespace

void check_map_options(const MapOptions& options) {
  const PictureOptions& picture = options.picture;
  const SourceOptions& source = options.source;
  if (!picture.camera.distances.empty() && picture.surface.mesh.empty())
    throw Error(ErrorCode::kUsage, "--distance requires --mesh");
  if (options.comparison.is_of_texels() && picture.shading.filter.is_drivers)
    throw Error(ErrorCode::kUsage,
                "--reference-of texels averages the texels that --taps and --level-bias select; found --anisotropy, "
                "with which the driver filters instead");
  for (const auto& [option, path] : {std::pair{"--albedo", &source.albedo}, std::pair{"--roughness", &source.roughness},
                                     std::pair{"--gloss", &source.gloss}, std::pair{"--weights", &source.weights}})
    if (!path->empty() && source.normals.empty())
      throw Error(ErrorCode::kUsage, fmt::format("{} requires --source, because both describe the baked map", option));
  if (!options.brdf_roughness.empty()) check_brdf_roughness(options);
  if (!options.comparison.kept_reference.empty() &&
      (!options.animation.folder.empty() || !picture.camera.distances.empty() || options.comparison.is_of_texels()))
    throw Error(ErrorCode::kUsage,
                "--keep-reference: found several views or --reference-of texels, expected one view and --reference-of "
                "pixel");
  const AnimationOptions& to = options.animation;
  if (picture.light.environment.empty() &&
      (picture.light.environment_turn || to.environment_turn || !to.environment.empty()))
    throw Error(ErrorCode::kUsage,
                "--environment-turn, --to-environment and --to-environment-turn require --environment");
  const bool has_frames = !options.animation.folder.empty();
  if (has_frames != options.animation.changes_anything())
    throw Error(ErrorCode::kUsage, has_frames
                                       ? "animate: nothing changes, expected --to-camera, --to-light, --to-brdf, ..."
                                       : "--to-camera, --to-light and so on need multum-view animate");
  if (!has_frames) check_picture_path(picture.output.path);
}

}  // namespace multum
