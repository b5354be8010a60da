// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_options.h"
#include "tools/command_line/decoding_option.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <set>
#include <utility>

#include "host/base/choices.h"
#include "host/base/error.h"
#include "host/brdf/brdf_text.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/command_line/usage_error.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

/// The option values that need more than a type.
const Choices<gl::MomentShading> kMomentShadings = {{"toksvig", gl::MomentShading::kToksvig},
                                                    {"lean", gl::MomentShading::kLean},
                                                    {"lean-jacobian", gl::MomentShading::kLeanJacobian}};

struct RawOptions {
  std::string camera;
  std::string distances;
  std::string up;
  std::vector<std::string> lights;
  std::vector<std::string> point_lights;
  std::vector<std::string> brdfs;
  std::vector<std::string> diffuse, specular;  // one for all, or one a BRDF
  std::string fixed_fresnel;
  std::string size = "640x480";
  std::string context = "auto";
  std::string formula = "product";
  std::string compare;
  std::string moments;
  std::string lookups = "level";
  std::string environment_mode = "prefiltered";
  std::string truth_of = "pixel";
  // Of the last frame.
  std::string to_camera, to_brdf, to_diffuse, to_specular;
  std::vector<std::string> to_lights, to_point_lights;
};

[[noreturn]] void refuse(const std::string& option, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kUsage, option + " '" + found + "': expected " + expected);
}

std::vector<float> parse_numbers(const std::string& option, const std::string& text, const std::string& expected) {
  std::vector<float> numbers;
  for (const std::string& word : CLI::detail::split(text, ',')) {
    float value = 0.0f;
    if (!CLI::detail::lexical_cast(word, value) || !std::isfinite(value)) refuse(option, text, expected);
    numbers.push_back(value);
  }
  return numbers;
}

/// CLI11's own range check lets "nan" pass.
CLI::Validator number_in(float low, float high) {
  const std::string range = fmt::format("in [{:g} - {:g}]", low, high);
  return CLI::Validator(
      [=](std::string& text) {
        float value = 0.0f;
        const bool fits = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
        return fits ? std::string() : fmt::format("'{}': expected a number {}", text, range);
      },
      "FLOAT " + range, "");
}

glm::vec3 parse_colour(const std::string& option, const std::string& text) {
  const char* const expected = "one or three numbers >= 0, as 0.5 or 0.8,0.2,0.1";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 1 && n.size() != 3) refuse(option, text, expected);
  const glm::vec3 colour = n.size() == 1 ? glm::vec3(n[0]) : glm::vec3(n[0], n[1], n[2]);
  if (colour.x < 0.0f || colour.y < 0.0f || colour.z < 0.0f) refuse(option, text, expected);
  return colour;
}

gl::Light parse_light(const std::string& option, const std::string& text) {
  const char* const expected = "x,y,z towards the light, not all 0, then perhaps its irradiance: 0.3,0.8,0.5,3.14";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 3 && n.size() != 4) refuse(option, text, expected);
  gl::Light light;
  light.direction = {n[0], n[1], n[2]};
  if (!(glm::length(light.direction) > 1e-12f)) refuse(option, text, expected);
  if (n.size() == 4) {
    if (n[3] < 0.0f) refuse(option, text, expected);
    light.irradiance = glm::vec3(n[3]);
  }
  return light;
}

gl::PointLight parse_point_light(const std::string& option, const std::string& text) {
  const char* const expected = "x,y,z of its place, then its intensity >= 0, grey or r,g,b: 0,2,1,3.14";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 4 && n.size() != 6) refuse(option, text, expected);
  gl::PointLight light{{n[0], n[1], n[2]}, n.size() == 4 ? glm::vec3(n[3]) : glm::vec3(n[3], n[4], n[5])};
  if (light.intensity.x < 0.0f || light.intensity.y < 0.0f || light.intensity.z < 0.0f) refuse(option, text, expected);
  return light;
}

void parse_camera(const std::string& option, const std::string& text, gl::Camera& camera) {
  const char* const expected =
      "eye x,y,z, target x,y,z and perhaps the vertical field of view in degrees (1..170): "
      "0,0,0.3,0,1,0,40";
  const std::vector<float> n = parse_numbers(option, text, expected);
  if (n.size() != 6 && n.size() != 7) refuse(option, text, expected);
  camera.eye = {n[0], n[1], n[2]};
  camera.target = {n[3], n[4], n[5]};
  if (n.size() == 7) camera.fov_y_degrees = n[6];
  const glm::vec3 view = camera.target - camera.eye;
  if (!(glm::length(view) > 1e-9f) || camera.fov_y_degrees < 1.0f || camera.fov_y_degrees > 170.0f)
    refuse(option, text, expected);
}

void parse_distances(const std::string& text, ViewOptions& options) {
  const char* const expected = "different numbers from 0.01 to 10000, times the distance of the camera: 1,5,25";
  options.distances = parse_numbers("--distance", text, expected);
  std::set<std::string> names;  // files are named so
  for (const float factor : options.distances)
    if (factor < 0.01f || factor > 1e4f || !names.insert(fmt::format("{:g}", factor)).second)
      refuse("--distance", text, expected);
  if (options.mesh.empty() || !options.reflectance.empty())
    throw Error(ErrorCode::kUsage, "--distance: is of a baked map or --material on a --mesh");
  if (!options.frames_folder.empty())
    throw Error(ErrorCode::kUsage, "--distance: is of single pictures; with --animate, use --to-camera");
}

bool looks_along(const gl::Camera& camera, const glm::vec3& direction) {
  const glm::vec3 view = camera.target - camera.eye;
  return glm::length(glm::cross(view, direction)) < 1e-4f * glm::length(view) * glm::length(direction);
}

/// What is up in the picture: meshes have it along +Y, as glTF does, and the plane along +Z.
void parse_up(const std::string& text, ViewOptions& options) {
  gl::Camera& camera = options.scene.camera;
  const bool is_plane = options.mesh.empty();
  options.up = is_plane ? glm::vec3(0.0f, 0.0f, 1.0f) : glm::vec3(0.0f, 1.0f, 0.0f);
  if (!text.empty()) {
    const char* const expected = "x,y,z, not all 0, and not along the line of sight: 0,0,1";
    const std::vector<float> n = parse_numbers("--up", text, expected);
    if (n.size() != 3) refuse("--up", text, expected);
    options.up = {n[0], n[1], n[2]};
    if (!(glm::length(options.up) > 1e-12f)) refuse("--up", text, expected);
    options.up = glm::normalize(options.up);
    if ((options.has_camera || is_plane) && looks_along(camera, options.up)) refuse("--up", text, expected);
  } else if (options.has_camera && looks_along(camera, options.up)) {
    // Looking straight up or down, another direction has to be up: further away on the plane, and away from who
    // looks at a mesh from the front.
    options.up = is_plane ? glm::vec3(0.0f, 1.0f, 0.0f) : glm::vec3(0.0f, 0.0f, -1.0f);
  }
  camera.up = options.up;
}

void parse_size(const std::string& text, ViewOptions& options) {
  int used = 0;
  if (std::sscanf(text.c_str(), "%dx%d%n", &options.width, &options.height, &used) != 2 ||
      static_cast<std::size_t>(used) != text.size() || options.width < 1 || options.height < 1)
    refuse("--size", text, "WIDTHxHEIGHT in pixels, as 640x480");
}

/// Each once, however often it is named: two pictures of one name would share a file.
std::vector<std::string> parse_compare(const std::string& text) {
  std::vector<std::string> names;
  for (const std::string& name : CLI::detail::split(text, ',')) {
    if (name != "truth" && name != "mip" && name != "toksvig" && name != "lean" && name != "lean-jacobian")
      refuse("--compare", text, "a list of truth, mip, toksvig, lean, lean-jacobian");
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

/// One thing is drawn: a baked map, or what takes its place.
void check_subject(const RawOptions& raw, const ViewOptions& o) {
  const int others = (o.mip.empty() ? 0 : 1) + (o.reflectance.empty() ? 0 : 1) + (o.lod.empty() ? 0 : 1) +
                     (o.materials.empty() ? 0 : 1);
  if (o.input.empty() && others == 0) throw Error(ErrorCode::kUsage, "file is required: see multum-view --help");
  if (others > 1 || (!o.input.empty() && others > 0))
    throw Error(ErrorCode::kUsage, "expected one of: a baked map, --mip, --reflectance, --lod, --material");
  if ((!o.reflectance.empty() || !o.materials.empty()) && o.mesh.empty())
    throw Error(ErrorCode::kUsage, "--reflectance and --material are for a surface, expected --mesh");
  if ((!o.mip.empty() || !o.lod.empty()) && !o.mesh.empty())
    throw Error(ErrorCode::kUsage, "--mip lies on the plane and --lod is a surface itself, found --mesh");
  if (others > 0 && (!raw.compare.empty() || !o.source.empty() || !o.frames_folder.empty() || !o.shaders.empty()))
    throw Error(ErrorCode::kUsage,
                "--compare, --source, --animate and --shaders are for baked maps; --lookup has what pyramids compare");
}

std::vector<std::string> parse_lookups(const std::string& text) {
  std::vector<std::string> names;
  for (const std::string& name : CLI::detail::split(text, ',')) {
    if (name != "truth" && name != "nearest" && name != "bilinear" && name != "level" && name != "driver")
      refuse("--lookup", text, "a list of truth, nearest, bilinear, level, driver");
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  // The others are compared with it.
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "truth"; });
  return names;
}

/// The last frame's scene: the first one's, but for what is said of it.
void finish_animation(const RawOptions& raw, ViewOptions& options) {
  const bool has_end = !raw.to_camera.empty() || !raw.to_brdf.empty() || !raw.to_diffuse.empty() ||
                       !raw.to_specular.empty() || !raw.to_lights.empty() || !raw.to_point_lights.empty();
  if (options.frames_folder.empty() == has_end)
    throw Error(ErrorCode::kUsage, has_end ? "--to-camera, --to-light and the like go with --animate FOLDER"
                                           : "--animate: say what changes: --to-camera, --to-light, --to-brdf, ...");
  gl::RenderScene& last = options.last_scene;
  last = options.scene;
  if (!has_end) return;
  if (!options.output.empty() || !options.pictures.empty())
    throw Error(ErrorCode::kUsage, "--animate writes FOLDER/frame_0000.png and so on: leave out -o and --pictures");
  if (!raw.to_camera.empty()) parse_camera("--to-camera", raw.to_camera, last.camera);
  options.has_last_camera = !raw.to_camera.empty();
  if (options.basis.size() > 1 && !(raw.to_brdf.empty() && raw.to_diffuse.empty() && raw.to_specular.empty()))
    throw Error(ErrorCode::kUsage,
                "--to-brdf, --to-diffuse and --to-specular change one BRDF, found several of --brdf");
  if (!raw.to_brdf.empty()) {
    const glm::vec3 diffuse = last.brdf.diffuse, specular = last.brdf.specular;
    last.brdf = parse_brdf("--to-brdf", raw.to_brdf, last.brdf.term_count);
    if (last.brdf.kind != options.scene.brdf.kind || last.brdf.kind == BrdfKind::kMeasured)
      refuse("--to-brdf", raw.to_brdf, "another parameter of the family that --brdf has");
    last.brdf.diffuse = diffuse;
    last.brdf.specular = specular;
  }
  if (!raw.to_diffuse.empty()) last.brdf.diffuse = parse_colour("--to-diffuse", raw.to_diffuse);
  if (!raw.to_specular.empty()) last.brdf.specular = parse_colour("--to-specular", raw.to_specular);
  const auto expect_count = [](const char* option, std::size_t found, std::size_t expected) {
    if (found != expected)
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: found {} lights, expected the {} of the first frame", option, found, expected));
  };
  if (!raw.to_lights.empty()) {
    expect_count("--to-light", raw.to_lights.size(), last.lights.size());
    for (std::size_t i = 0; i < raw.to_lights.size(); ++i) last.lights[i] = parse_light("--to-light", raw.to_lights[i]);
  }
  if (!raw.to_point_lights.empty()) {
    expect_count("--to-point-light", raw.to_point_lights.size(), last.point_lights.size());
    for (std::size_t i = 0; i < raw.to_point_lights.size(); ++i)
      last.point_lights[i] = parse_point_light("--to-point-light", raw.to_point_lights[i]);
  }
}

void finish(const RawOptions& raw, ViewOptions& options) {
  check_subject(raw, options);
  options.lookups = parse_lookups(raw.lookups);
  gl::RenderScene& scene = options.scene;
  if (!raw.camera.empty()) parse_camera("--camera", raw.camera, scene.camera);
  options.has_camera = !raw.camera.empty();
  if (!raw.distances.empty()) parse_distances(raw.distances, options);
  parse_up(raw.up, options);
  if (!raw.lights.empty() || !raw.point_lights.empty() || !options.environment.empty()) scene.lights.clear();
  scene.environment_mode =
      raw.environment_mode == "sh" ? gl::EnvironmentMode::kHarmonics : gl::EnvironmentMode::kPrefiltered;
  scene.environment_up = options.up;
  options.truth_of_texels = raw.truth_of == "texels";
  if (options.truth_of_texels && options.anisotropy > 1.0f)
    throw Error(ErrorCode::kUsage, "--truth-of texels: is the trilinear filter's; found --anisotropy, expected none");
  if (raw.lights.size() > gl::kLightCountMax) throw Error(ErrorCode::kUsage, "--light: at most 8 lights");
  for (const std::string& light : raw.lights) scene.lights.push_back(parse_light("--light", light));
  if (raw.point_lights.size() > gl::kLightCountMax) throw Error(ErrorCode::kUsage, "--point-light: at most 8 lights");
  for (const std::string& light : raw.point_lights)
    scene.point_lights.push_back(parse_point_light("--point-light", light));
  options.has_brdf = !raw.brdfs.empty();
  if (raw.brdfs.size() > kWeightCountMax) throw Error(ErrorCode::kUsage, "--brdf: at most 4, a weight each");
  const std::vector<std::string> brdfs = raw.brdfs.empty() ? std::vector<std::string>{"blinn-phong:100"} : raw.brdfs;
  for (const auto& [option, colours] : {std::pair{"--diffuse", &raw.diffuse}, std::pair{"--specular", &raw.specular}})
    if (colours->size() > 1 && colours->size() != brdfs.size())
      throw Error(ErrorCode::kUsage, fmt::format("{}: found {}, expected one, or one for each of {} --brdf", option,
                                                 colours->size(), brdfs.size()));
  for (std::size_t k = 0; k < brdfs.size(); ++k) {
    Brdf brdf = parse_brdf("--brdf", brdfs[k], scene.brdf.term_count);
    const auto of_this = [&](const std::vector<std::string>& colours) { return colours[colours.size() > 1 ? k : 0]; };
    if (!raw.diffuse.empty()) brdf.diffuse = parse_colour("--diffuse", of_this(raw.diffuse));
    if (!raw.specular.empty()) brdf.specular = parse_colour("--specular", of_this(raw.specular));
    if (!raw.fixed_fresnel.empty()) brdf.fixed_fresnel = parse_colour("--fixed-fresnel", raw.fixed_fresnel);
    options.basis.push_back(brdf);
  }
  if (!raw.fixed_fresnel.empty() && !options.environment.empty())
    throw Error(ErrorCode::kUsage, "--fixed-fresnel: is for lights alone; found --environment, expected none");
  scene.brdf = options.basis[0];
  parse_size(raw.size, options);
  options.context = gl::parse_context_backend(raw.context).value();
  options.formula = raw.formula == "paper" ? gl::LobeFormula::kPaper : gl::LobeFormula::kProduct;
  if (!raw.moments.empty()) options.moments = find_choice(kMomentShadings, raw.moments);
  if (!raw.compare.empty()) options.compare = parse_compare(raw.compare);
  for (const auto& [option, path] :
       {std::pair{"--albedo", &options.albedo}, std::pair{"--roughness", &options.roughness},
        std::pair{"--gloss", &options.gloss}, std::pair{"--weights", &options.weights}})
    if (!path->empty() && options.source.empty())
      throw Error(ErrorCode::kUsage,
                  fmt::format("{} goes with --source: both describe the map that the file was baked from", option));
  if (options.formula == gl::LobeFormula::kPaper && scene.brdf.kind != BrdfKind::kBlinnPhong)
    throw Error(ErrorCode::kUsage, "--formula paper is Blinn-Phong's; use it with --brdf blinn-phong:S");
  finish_animation(raw, options);
  if (options.frames_folder.empty()) check_picture_path(options.output);
}

void add_options(CLI::App& app, ViewOptions& o, RawOptions& raw) {
  app.add_option("file", o.input, "baked map, *.ndf.exr");
  app.add_option("-o,--output", o.output, "picture to write: .png (sRGB) or .exr (linear floats)");
  app.add_option(
      "--animate", o.frames_folder,
      "instead of -o: a folder for frame_0000.png and so on, between the scene that is said and what --to-... "
      "change of it, evenly; exponents and roughnesses by equal factors");
  app.add_option("--frames", o.frame_count, "of --animate")->check(CLI::Range(2, 9999))->capture_default_str();
  app.add_option("--to-camera", raw.to_camera, "--camera of the last frame");
  app.add_option("--to-light", raw.to_lights, "--light of the last frame, as often as --light");
  app.add_option("--to-point-light", raw.to_point_lights, "--point-light of the last frame");
  app.add_option("--to-brdf", raw.to_brdf, "--brdf of the last frame, of the same family");
  app.add_option("--to-diffuse", raw.to_diffuse, "--diffuse of the last frame");
  app.add_option("--to-specular", raw.to_specular, "--specular of the last frame");
  app.add_option("--pictures", o.pictures,
                 "also write each picture by itself: PREFIX_multum.png, PREFIX_truth.png, "
                 "PREFIX_multum_difference.png, ...");
  app.add_option("--compare", raw.compare,
                 "also draw these beside it, of truth,mip,toksvig,lean,lean-jacobian; with truth: errors too");
  app.add_option("--source", o.source,
                 "normal map that the file was baked from, for the truth and the baselines (default: level 0 of the "
                 "file) and, in files baked with --first-level, for the finest levels");
  app.add_option("--colour-map", o.colour_map,
                 "colours for a file of lobes that has none: a pyramid of multum mip, as a scene's bake leaves it");
  app.add_flag("--stored-only", o.stored_only,
               "of a file baked with --first-level: draw its finest level where a finer one is asked for, without "
               "--source");
  app.add_option("--albedo", o.albedo, "the source's colours");
  CLI::Option* const roughness =
      app.add_option("--roughness", o.roughness, "the source's roughness, FILE or FILE:CHANNEL, as the bake had it");
  app.add_option("--gloss", o.gloss, "the same of a gloss map, roughness = 1 - gloss")->excludes(roughness);
  app.add_option("--weights", o.weights, "the source's weights of basis BRDFs");
  app.add_option("--mesh", o.mesh,
                 "OBJ, glTF or GLB to put the map on (default: a plane z = 0 that runs to the "
                 "horizon: x from -30 to 30, y from 0 to 60)");
  app.add_option("--repeat", o.repeat, "how often the map repeats across the plane or uv unit (default: 60, mesh 1)")
      ->check(number_in(1e-6f, 1e6f));
  app.add_option("--camera", raw.camera,
                 "eye and target: x,y,z,x,y,z[,field of view in degrees] (default: the "
                 "plane from 0,0,0.3 to 0,1,-0.0939; the whole mesh)");
  app.add_option("--distance", raw.distances,
                 "with --mesh: pictures from near and far, a list of factors of the camera's distance; 1,5,25 writes "
                 "NAME_1.png, NAME_5.png and NAME_25.png for -o NAME.png");
  app.add_option("--up", raw.up, "x,y,z that is up in the picture (default: 0,0,1; with a mesh 0,1,0)");
  app.add_option("--light", raw.lights, "towards a distant light: x,y,z[,irradiance]; up to 8 times");
  app.add_option("--point-light", raw.point_lights,
                 "at x,y,z, with an intensity: x,y,z,i or x,y,z,r,g,b; up to 8 times");
  app.add_option(
      "--environment", o.environment,
      "light from everywhere, seen behind what is drawn: an image over latitude and longitude, .exr or .hdr");
  app.add_flag("--no-background", o.no_background, "black behind what is drawn, not the environment");
  app.add_option("--environment-mode", raw.environment_mode,
                 "its highlights: prefiltered (mips convolved with vMFs) or sh (harmonics to order 8, for broad BRDFs)")
      ->check(CLI::IsMember({"sh", "prefiltered"}))
      ->capture_default_str();
  app.add_option(
         "--brdf", raw.brdfs,
         "lambert, blinn-phong:S, torrance-sparrow:SIGMA, cook-torrance:SIGMA[,F0], ggx:ROUGHNESS[,F0], or a "
         "measured one's file (.brdf text, .binary of MERL, .json of a fit); several times: basis BRDFs, which the "
         "file's weights blend; files with roughness in have their own (default: blinn-phong:100)")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--brdf-terms", o.scene.brdf.term_count,
                 "vMF densities that GGX and measured facets are a sum of, over lobes: more is nearer and slower")
      ->check(CLI::Range(1, kBrdfTermCountMax))
      ->capture_default_str();
  app.add_option(
         "--diffuse", raw.diffuse,
         "diffuse reflectance, grey or r,g,b (default: 0.5, or what was measured); several times: of each --brdf")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--specular", raw.specular,
                 "specular factor, grey or r,g,b (default: 0.1; 1 where Fresnel or a measurement is in it); several "
                 "times: of each --brdf")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--fixed-fresnel", raw.fixed_fresnel,
                 "grey or r,g,b in the place of the BRDF's Fresnel term at every angle, as a scene's plan may have it; "
                 "its code is left out");
  app.add_option("--formula", raw.formula, "lobe and BRDF: product (of mean cosines) or paper (Han 2007, eq. 20)")
      ->check(CLI::IsMember({"product", "paper"}))
      ->capture_default_str();
  app.add_flag("--shade-first", o.shade_first,
               "shade the lobes of all eight texels of a trilinear footprint, then mix: what lobes of --unaligned "
               "bakes need, slow");
  app.add_option("--moments", raw.moments,
                 "how a file of moments is shaded: toksvig, lean or lean-jacobian (default: lean-jacobian)")
      ->check(CLI::IsMember(choice_names(kMomentShadings)));
  app.add_option("--size", raw.size, "of each picture, pixels")->capture_default_str();
  app.add_option("--samples", o.samples,
                 "a pixel of --compare truth, which is drawn so many times: seconds in software, with a progress bar")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option("--truth-of", raw.truth_of,
                 "what the truth averages over: the pixel, or the texels that a trilinear filter takes there, so that "
                 "what is off is what the baked texels do not hold")
      ->check(CLI::IsMember({"pixel", "texels"}))
      ->capture_default_str();
  app.add_option("--anisotropy", o.anisotropy, "of every filtered texture")
      ->check(number_in(1.0f, 16.0f))
      ->capture_default_str();
  app.add_option("--exposure", o.exposure, "brightness of a PNG")->check(number_in(1e-6f, 1e6f))->capture_default_str();
  app.add_option("--context", raw.context, "auto, osmesa (software) or egl")
      ->check(CLI::IsMember({"auto", "osmesa", "egl"}))
      ->capture_default_str();
  app.option_defaults()->group("In the place of a baked map (docs/WILLIAMS.md)");
  app.add_option("--material", o.materials,
                 "NAME=FILE.ndf.exr: draws the --mesh with its own materials, this one with a map baked for it; once a "
                 "material (multum materials)");
  app.add_option("--mip", o.mip, "a pyramid of colours, of multum mip, on the plane");
  app.add_option("--reflectance", o.reflectance, "a map over normals, of multum reflectance, on the --mesh");
  app.add_option("--lookup", raw.lookups,
                 "how these are looked up, a list of nearest, bilinear (finest level), level (the longer side of the "
                 "pixel), driver, and truth (supersampled)")
      ->capture_default_str();
  app.add_option("--level-bias", o.level_bias,
                 "added to the level (default: 0 for --mip, as the GL; -0.79 for --reflectance, as wide as the pixel)")
      ->check(number_in(-16.0f, 16.0f));
  app.add_option("--shifts", o.shifts, "with --reflectance and truth: measure flicker over so many sub-pixel shifts")
      ->check(CLI::Range(2, 256));
  app.add_option("--lod", o.lod, "a surface, of multum lod, as a mesh of --level");
  app.add_option("--level", o.level, "level of detail, any number from 0")
      ->check(number_in(0.0f, 32.0f))
      ->capture_default_str();
  app.option_defaults()->group("Options");
  app.add_option("--report", o.report, "write errors, times and settings as JSON");
  app.add_option(
      "--shaders", o.shaders,
      "of a baked map: write the shader variants that were drawn with as JSON: flags, text, and the uniforms "
      "that the driver kept");
  add_parameter_options(app, o.reading,
                        {"bumpformat", "green", "signed", "unsigned", "two_channel", "height_scale", "normal_scale",
                         "fixnan", "repair_max"},
                        false);
  add_decoding_option(app);
}

}  // namespace

std::optional<ViewOptions> parse_view_options(int argc, char** argv, int* exit_code) {
  ViewOptions options;
  RawOptions raw;
  CLI::App app(
      "multum-view renders a baked map without a window, in software or on a GPU.\n\n"
      "  multum-view bricks.ndf.exr -o frame.png\n"
      "  multum-view bricks.ndf.exr --source bricks_normal.png --compare truth,mip,toksvig,lean-jacobian -o sheet.png\n"
      "  multum-view bricks.ndf.exr --mesh teapot.obj --brdf blinn-phong:500 --light 1,1,1 -o teapot.exr\n"
      "  multum-view bricks.ndf.exr --brdf ggx:0.5 --to-brdf ggx:0.1 --animate frames/ --frames 60\n"
      "  multum-view --scene out/plan.json --object wall -o wall.png           what multum bake scene.toml made\n"
      "  multum-view out/ --sample 3,5 -o frame.png          textures of `multum infer`; --sample --help says more\n\n"
      "Exit codes: 0 done, 2 wrong command line, 3 unusable file, 4 no GL or no disk.",
      "multum-view");
  app.set_version_flag("--version", std::string("multum-view ") + MULTUM_VERSION);
  app.failure_message(usage_error);
  add_options(app, options, raw);
  try {
    app.parse(argc, argv);
    if (options.output.empty() && options.frames_folder.empty()) throw CLI::RequiredError("--output");
  } catch (const CLI::ParseError& error) {
    *exit_code = print_parse_error(app, error);
    return std::nullopt;
  }
  finish(raw, options);
  return options;
}

}  // namespace multum
