// SPDX-License-Identifier: Apache-2.0
// multum mip, reflectance, lod: pyramids of images, of lights over normals, of surfaces (Williams 1983).
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "host/bake/map_options.h"
#include "host/bake/mip_bake.h"
#include "host/bake/reflectance_bake.h"
#include "host/base/error.h"
#include "host/base/machine.h"
#include "host/base/shown_text.h"
#include "tools/command_line/choices.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

const Choices<ColourEncoding> kColourEncodings = {{"auto", ColourEncoding::kAuto},
                                                  {"srgb", ColourEncoding::kSrgb},
                                                  {"linear", ColourEncoding::kLinear},
                                                  {"data", ColourEncoding::kData}};
const Choices<StorageEncoding> kPyramidEncodings = {{"half", StorageEncoding::kHalf},
                                                    {"float", StorageEncoding::kFloat}};
const Choices<PyramidKind> kSurfaceKinds = {{"heights", PyramidKind::kHeight}, {"positions", PyramidKind::kPosition}};

struct MipOptions {
  CommonOptions common;
  std::string device;
  MipJob job;
  std::optional<WrapMode> wrap, wrap_s, wrap_t;
};

struct ReflectanceOptions {
  CommonOptions common;
  std::string device;
  ReflectanceJob job;
  std::vector<std::string> lights;
  std::string viewer, up, brdf = "blinn-phong:100", diffuse = "0.5", specular = "0.1";
};

void add_output_options(CLI::App& command, std::string& output, std::string& report, BakedWriteOptions& writing) {
  command.add_option("-o,--output", output, "file to write, *.exr: tiled, mip-mapped, linear")->required();
  command.add_option("--report", report, "write times, counts and the content's hash as JSON");
  command.add_option("--compression", writing.compression, "none, rle, zips, zip or piz, zip:1..9")
      ->capture_default_str();
}

void add_device_options(CLI::App& command, std::string& device, std::uint64_t& memory_bytes, bool& force) {
  command.add_option("--device", device, "OpenCL device: a number of `multum devices` or part of a name");
  command
      .add_option("--memory", memory_bytes,
                  "for buffers and the image, as 64M or 1G; larger images go by way of a scratch file (256M)")
      ->transform(CLI::AsSizeValue(false));
  command.add_flag("--force", force, "write even if the output is from the same file with the same settings");
}

void add_wrap_options(CLI::App& command, MipOptions& o, const char* usual) {
  add_choice(command, "--wrap", o.wrap, kWrapModes,
             std::string("beyond the border: black, clamp, periodic or mirror (default: ") + usual + ")");
  add_choice(command, "--swrap", o.wrap_s, kWrapModes, "the same for s (x) alone");
  add_choice(command, "--twrap", o.wrap_t, kWrapModes, "the same for t (y) alone");
}

int print_result(const CommonOptions& common, const std::string& output, PyramidKind kind, const MipReport& report) {
  if (common.quiet) return 0;
  if (report.unchanged) {
    print_shown(stdout, "%s: unchanged\n", output.c_str());
    return 0;
  }
  print_shown(stdout, "%s: %d levels of %s, %d x %d, from %s\n", output.c_str(), report.level_count,
              pyramid_kind_name(kind), report.width, report.height,
              report.format.empty() ? "lights" : report.format.c_str());
  if (report.clamped_count > 0)
    print_shown(stdout, "%lld texels hold no colour (negative, NaN or infinite) and count as black\n",
                static_cast<long long>(report.clamped_count));
  if (report.limited_count > 0)
    print_shown(stdout, "%llu values are beyond what half floats hold and became 65504; -d float keeps them\n",
                static_cast<unsigned long long>(report.limited_count));
  if (common.verbose)
    print_shown(stdout, "read %.2f s, average %.2f s, write %.2f s on %s\nchecksum %s\n", report.read_seconds,
                report.average_seconds, report.write_seconds, report.device.c_str(), report.content_hash.c_str());
  return 0;
}

int run_mip(MipOptions& o) {
  o.job.threads = o.job.writing.threads = apply(o.common);
  keep_freed_memory();
  if (o.wrap) o.job.wrap_s = o.job.wrap_t = *o.wrap;
  if (o.wrap_s) o.job.wrap_s = *o.wrap_s;
  if (o.wrap_t) o.job.wrap_t = *o.wrap_t;
  if (!(std::isfinite(o.job.scale) && o.job.scale != 0.0f))
    throw Error(ErrorCode::kUsage, fmt::format("--scale is {}, expected a number that is not 0", o.job.scale));
  Device device = Device::when_needed(DeviceChoice{o.device});
  const auto progress = make_progress(o.common);
  return print_result(o.common, o.job.output, o.job.kind, bake_mip(o.job, device, progress.get()));
}

glm::dvec3 three_numbers(const std::string& option, const std::string& text, bool one_will_do) {
  double x = 0, y = 0, z = 0;
  char rest = 0;
  const int found = std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &x, &y, &z, &rest);
  const bool finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
  if (found == 3 && finite) return {x, y, z};
  if (one_will_do && found == 1 && finite && text.find(',') == std::string::npos &&
      std::sscanf(text.c_str(), "%lf%c", &x, &rest) == 1)
    return glm::dvec3(x);
  throw Error(ErrorCode::kUsage, fmt::format("{} is '{}', expected {}", option, text,
                                             one_will_do ? "one or three numbers, as 0.5 or 0.8,0.2,0.1" : "x,y,z"));
}

ReflectanceLight parse_light(const std::string& text) {
  ReflectanceLight light;
  double x = 0, y = 0, z = 0, r = 0, g = 0, b = 0;
  char rest = 0;
  const int found = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &x, &y, &z, &r, &g, &b, &rest);
  if (found != 3 && found != 4 && found != 6)
    throw Error(ErrorCode::kUsage, "--light is '" + text +
                                       "', expected x,y,z towards the light, then perhaps its irradiance, grey or "
                                       "r,g,b: 0.3,0.8,0.5,3.14");
  light.direction = {x, y, z};
  if (found == 4) light.irradiance = glm::dvec3(r);
  if (found == 6) light.irradiance = {r, g, b};
  return light;
}

int run_reflectance(ReflectanceOptions& o) {
  o.job.threads = o.job.writing.threads = apply(o.common);
  for (const std::string& text : o.lights) o.job.lights.push_back(parse_light(text));
  if (!o.viewer.empty()) o.job.viewer = three_numbers("--viewer", o.viewer, false);
  if (!o.up.empty()) o.job.up = three_numbers("--up", o.up, false);
  o.job.diffuse = three_numbers("--diffuse", o.diffuse, true);
  o.job.specular = three_numbers("--specular", o.specular, true);
  char rest = 0;
  if (std::sscanf(o.brdf.c_str(), "blinn-phong:%f%c", &o.job.exponent, &rest) != 1)
    throw Error(ErrorCode::kUsage, "--brdf is '" + o.brdf + "', expected blinn-phong:S with S 1..100000");
  validate(o.job);  // before a device is looked for
  Device device = Device::when_needed(DeviceChoice{o.device});
  const auto progress = make_progress(o.common);
  return print_result(o.common, o.job.output, PyramidKind::kReflectance,
                      bake_reflectance(o.job, device, progress.get()));
}

void add_mip(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<MipOptions>();
  CLI::App* mip =
      app.add_subcommand("mip", "make a mip pyramid of colours, or of other data, filtered in linear light");
  mip->add_option("image", o->job.input, "PNG, TIFF, EXR, JPEG or WebP")->required();
  add_output_options(*mip, o->job.output, o->job.report, o->job.writing);
  add_choice(*mip, "--colours", o->job.colours, kColourEncodings,
             "how the numbers are meant: auto (integers sRGB unless the file says otherwise, floats linear), srgb, "
             "linear, or data (no colours: may be negative)");
  add_choice(*mip, "-d,--data-format", o->job.encoding, kPyramidEncodings, "what is stored is rounded to");
  add_wrap_options(*mip, *o, "periodic");
  add_device_options(*mip, o->device, o->job.memory_bytes, o->job.force);
  add_common_options(*mip, o->common);
  add_decoding_option(*mip);
  mip->callback([o, exit_code] { *exit_code = run_mip(*o); });
}

void add_reflectance(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<ReflectanceOptions>();
  CLI::App* command = app.add_subcommand(
      "reflectance", "bake lights into a mip-mapped map over normals, which antialiases highlights on curved surfaces");
  ReflectanceJob& job = o->job;
  add_output_options(*command, job.output, job.report, job.writing);
  command->add_option("--light", o->lights, "towards a distant light: x,y,z[,irradiance, grey or r,g,b]; repeatable");
  command->add_option("--environment", job.environment,
                      "latitude-longitude image of light from everywhere; +Y on top, -Z in the middle");
  command->add_option("--environment-scale", job.environment_scale, "its radiance times this")->capture_default_str();
  command->add_option("--viewer", o->viewer, "x,y,z towards the distant viewer (default: 0,0,1)");
  command->add_option("--up", o->up, "x,y,z that is up in the map (default: 0,1,0)");
  command->add_option("--brdf", o->brdf, "of the surface: blinn-phong:S")->capture_default_str();
  command->add_option("--diffuse", o->diffuse, "diffuse reflectance, grey or r,g,b")->capture_default_str();
  command->add_option("--specular", o->specular, "specular factor, grey or r,g,b")->capture_default_str();
  command->add_option("--size", job.size, "texels a side, 4 to 8192")->capture_default_str();
  command->add_option("--texel-samples", job.sample_side, "normals averaged along a side of a texel, 1 to 16")
      ->capture_default_str();
  add_choice(*command, "-d,--data-format", job.encoding, kPyramidEncodings, "what is stored is rounded to");
  add_device_options(*command, o->device, job.memory_bytes, job.force);
  add_common_options(*command, o->common);
  add_decoding_option(*command);
  command->callback([o, exit_code] { *exit_code = run_reflectance(*o); });
}

void add_lod(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<MipOptions>();
  o->job.kind = PyramidKind::kHeight;
  o->job.encoding = StorageEncoding::kFloat;
  o->job.wrap_s = o->job.wrap_t = WrapMode::kClamp;
  CLI::App* lod = app.add_subcommand("lod", "make a level-of-detail pyramid of a height field or a grid of positions");
  lod->add_option("image", o->job.input, "heights (integers: 0 to 1), or x, y, z of a grid of points")->required();
  add_output_options(*lod, o->job.output, o->job.report, o->job.writing);
  add_choice(*lod, "--of", o->job.kind, kSurfaceKinds, "heights (the first channel) or positions (three channels)");
  lod->add_option("--scale", o->job.scale, "every number times this")->capture_default_str();
  add_choice(*lod, "-d,--data-format", o->job.encoding, kPyramidEncodings, "what is stored is rounded to");
  add_wrap_options(*lod, *o, "clamp");
  add_device_options(*lod, o->device, o->job.memory_bytes, o->job.force);
  add_common_options(*lod, o->common);
  add_decoding_option(*lod);
  lod->callback([o, exit_code] { *exit_code = run_mip(*o); });
}

}  // namespace

void add_pyramid_commands(CLI::App& app, int* exit_code) {
  add_mip(app, exit_code);
  add_reflectance(app, exit_code);
  add_lod(app, exit_code);
}

}  // namespace multum
