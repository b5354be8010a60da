// SPDX-License-Identifier: Apache-2.0
// Implements multum mip, reflectance and lod, which make pyramids of images, of reflected light by normal, and of
// surfaces (Williams 1983).
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "host/bakes/pyramid/mip_bake.h"
#include "host/bakes/pyramid/reflectance_bake.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/parameters/pyramid_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

const Choices<PyramidKind> kSurfaceKinds = {{"heights", PyramidKind::kHeight}, {"positions", PyramidKind::kPosition}};

struct MipOptions {
  explicit MipOptions(const ParameterTable& table) : values(table) {}
  CommonOptions common;
  ParameterValues values;
  MipJob job;
};

struct ReflectanceOptions {
  CommonOptions common;
  ParameterValues values{reflectance_parameters()};
  ReflectanceJob job;
};

// Applies the parameters that the three jobs share.
template <typename Job>
void apply_shared(const ParameterValues& values, Job& job) {
  job.report = values.text("report").value_or(job.report);
  job.writing.compression = values.text("compression").value_or(job.writing.compression);
  job.encoding = values.choice("data_format", kStorageEncodings).value_or(job.encoding);
  if (const auto bytes = values.bytes("memory")) job.memory_bytes = static_cast<std::uint64_t>(*bytes);
  job.force = values.flag("force");
}

DeviceChoice device_of(const ParameterValues& values) { return {values.text("device").value_or("")}; }

void add_output_option(CLI::App& command, std::string& output) {
  command.add_option("-o,--output", output, "file to write, *.exr: tiled, mip-mapped, linear")->required();
}

int print_result(const CommonOptions& common, const std::string& output, PyramidKind kind, const MipReport& report) {
  if (common.json) {
    OrderedJson json = {{"output", path_json(output)}, {"kind", pyramid_kind_name(kind)}};
    json.update(parsed(report.to_json()));
    print_json(json);
  }
  if (!prints_text(common)) return 0;
  if (report.unchanged) {
    print_shown(stdout, "%s: unchanged\n", output.c_str());
    return 0;
  }
  print_shown(stdout, "%s: %d levels of %s, %d x %d, from %s\n", output.c_str(), report.level_count,
              pyramid_kind_name(kind), report.width, report.height,
              report.format.empty() ? "lights" : report.format.c_str());
  if (report.clamped_count > 0)
    print_shown(stdout, "%lld texels are not colours (negative, NaN or infinite) and count as black\n",
                static_cast<long long>(report.clamped_count));
  if (report.limited_count > 0)
    print_shown(stdout, "%llu values are too large for half floats and became 65504; -d float keeps them\n",
                static_cast<unsigned long long>(report.limited_count));
  if (common.verbose)
    print_shown(stdout, "read %.2f s, average %.2f s, write %.2f s on %s\nchecksum %s\n", report.read_seconds,
                report.average_seconds, report.write_seconds, report.device.c_str(), report.content_hash.c_str());
  return 0;
}

int run_mip(MipOptions& o) {
  o.job.threads = o.job.writing.threads = apply(o.common);
  keep_freed_memory();
  const ParameterValues& values = o.values;
  apply_shared(values, o.job);
  for (const char* name : {"wrap", "swrap"})
    if (const auto mode = values.text(name)) o.job.wrap_s = *parse_wrap_mode(*mode);
  for (const char* name : {"wrap", "twrap"})
    if (const auto mode = values.text(name)) o.job.wrap_t = *parse_wrap_mode(*mode);
  if (&values.table() == &lod_parameters()) {
    o.job.kind = values.choice("of", kSurfaceKinds).value_or(o.job.kind);
    o.job.scale = static_cast<float>(values.number("scale").value_or(1.0));
  } else {
    o.job.colours = values.choice("colours", kColourEncodings).value_or(o.job.colours);
  }
  Device device = Device::when_needed(device_of(values));
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
  throw Error(ErrorCode::kUsage,
              fmt::format("{} is '{}', expected {}", option, text,
                          one_will_do ? "one or three numbers, such as 0.5 or 0.8,0.2,0.1" : "x,y,z"));
}

ReflectanceLight parse_light(const std::string& text) {
  ReflectanceLight light;
  double x = 0, y = 0, z = 0, r = 0, g = 0, b = 0;
  char rest = 0;
  const int found = std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &x, &y, &z, &r, &g, &b, &rest);
  if (found != 3 && found != 4 && found != 6)
    throw Error(ErrorCode::kUsage, "--light is '" + text +
                                       "', expected x,y,z towards the light, then optionally its irradiance, grey or "
                                       "r,g,b, such as 0.3,0.8,0.5,3.14");
  light.direction = {x, y, z};
  if (found == 4) light.irradiance = glm::dvec3(r);
  if (found == 6) light.irradiance = {r, g, b};
  return light;
}

int run_reflectance(ReflectanceOptions& o) {
  const ParameterValues& values = o.values;
  ReflectanceJob& job = o.job;
  job.threads = job.writing.threads = apply(o.common);
  apply_shared(values, job);
  for (const std::string& text : CLI::detail::split(values.text("light").value_or(""), ';'))
    if (!text.empty()) job.lights.push_back(parse_light(text));
  job.environment = values.text("environment").value_or("");
  if (const auto scale = values.number("environment_scale")) job.environment_scale = static_cast<float>(*scale);
  const auto numbers = [&](const char* name, bool one_will_do, glm::dvec3& value) {
    const auto text = values.text(name);
    if (text) value = three_numbers(values.table().at(name).option(), *text, one_will_do);
  };
  numbers("viewer", false, job.viewer);
  numbers("up", false, job.up);
  numbers("diffuse", true, job.diffuse);
  numbers("specular", true, job.specular);
  job.size = values.integer("size").value_or(job.size);
  job.sample_side = values.integer("texel_samples").value_or(job.sample_side);
  const std::string brdf = values.text("brdf").value_or(values.table().at("brdf").default_text);
  char rest = 0;
  if (std::sscanf(brdf.c_str(), "blinn-phong:%f%c", &job.exponent, &rest) != 1)
    throw Error(ErrorCode::kUsage, "--brdf is '" + brdf + "', expected blinn-phong:S with S from 1 to 100000");
  validate(o.job);  // called before a device is selected
  Device device = Device::when_needed(device_of(values));
  const auto progress = make_progress(o.common);
  return print_result(o.common, o.job.output, PyramidKind::kReflectance,
                      bake_reflectance(o.job, device, progress.get()));
}

void add_mip(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<MipOptions>(mip_parameters());
  CLI::App* mip = app.add_subcommand("mip", "make a mip pyramid of colours or other data, averaged in linear light");
  mip->add_option("image", o->job.input, "image to read: PNG, TIFF, EXR, JPEG or WebP")->required();
  add_output_option(*mip, o->job.output);
  add_parameter_options(*mip, o->values);
  add_common_options(*mip, o->common);
  add_decoding_option(*mip);
  mip->callback([o, exit_code] { *exit_code = run_mip(*o); });
}

void add_reflectance(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<ReflectanceOptions>();
  CLI::App* command =
      app.add_subcommand("reflectance",
                         "bake the light reflected by each normal into a mip-mapped map, for alias-free highlights on "
                         "curved surfaces");
  add_output_option(*command, o->job.output);
  add_parameter_options(*command, o->values);
  add_common_options(*command, o->common);
  add_decoding_option(*command);
  command->callback([o, exit_code] { *exit_code = run_reflectance(*o); });
}

void add_lod(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<MipOptions>(lod_parameters());
  o->job.kind = PyramidKind::kHeight;
  o->job.encoding = StorageEncoding::kFloat;
  o->job.wrap_s = o->job.wrap_t = WrapMode::kClamp;
  CLI::App* lod = app.add_subcommand("lod", "make a pyramid of levels of detail from heights or a grid of positions");
  lod->add_option("image", o->job.input,
                  "image of heights (integers are scaled to 0 to 1), or of the positions x, y, "
                  "z of a grid")
      ->required();
  add_output_option(*lod, o->job.output);
  add_parameter_options(*lod, o->values);
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
