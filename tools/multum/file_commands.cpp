// SPDX-License-Identifier: Apache-2.0
// Implements multum info, verify and devices.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/bakes/accuracy/accuracy_table.h"
#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/choices.h"
#include "tools/multum/commands.h"
#include "tools/multum/fields/field_commands.h"
#include "tools/multum/info_json.h"

namespace multum {
namespace {

// Rounds floats to the decimal number that the user gave. For example, 0.00999999977 becomes 0.01.
std::string rounded_settings(const std::string& text) {
  nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) return text;
  for (auto& [name, value] : json.items())
    if (value.is_number_float()) value = std::stod(fmt::format("{:g}", value.get<double>()));
  return json.dump();
}

std::string measured_error(const std::string& text) {
  const std::optional<StatedErrors> stated = parse_measured_error(text);
  if (stated && stated->rows.empty()) return "measured error  not measured\n";
  if (!stated) return fmt::format("measured error  {}\n", text);
  return footprint_error_text(stated->footprint_errors) + accuracy_table(stated->rows);
}

std::string size_text(std::uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} bytes", bytes);
  const auto kib = static_cast<double>(bytes) / 1024.0;
  return kib < 1024.0 ? fmt::format("{:.1f} KiB", kib) : fmt::format("{:.1f} MiB", kib / 1024.0);
}

// The lines of `multum info` that depend on the representation. They describe the texel contents and the losses of the
// encoding.
struct InfoKind {
  Representation representation;
  std::string (*texels)(const std::string& path, const BakedHeader& file);
  std::string (*survives)(const BakedHeader& file);
};

std::string material_texts(const BakedHeader& file) {
  std::string text;
  if (file.weight_count > 0) text += fmt::format(", weights of {} basis BRDFs", file.weight_count);
  if (file.has_roughness)
    text += fmt::format(", with the width of the BRDF (mean cosine {:.3f})", static_cast<double>(file.mean_cosine));
  return text;
}

constexpr InfoKind kInfoKinds[] = {
    {Representation::kMovmf,
     [](const std::string& path, const BakedHeader& file) {
       return fmt::format("{} von Mises-Fisher lobes per texel{}{}", read_movmf_header(path).lobe_count(),
                          file.has_colours ? ", with a colour per lobe" : "", material_texts(file));
     },
     [](const BakedHeader& file) {
       return fmt::format("keeps kappa up to {:.0f}", static_cast<double>(storage_kappa_max(file.encoding)));
     }},
    {Representation::kGmm,
     [](const std::string& path, const BakedHeader& file) {
       return fmt::format("{} planar Gaussians per texel{}{}", read_movmf_header(path).lobe_count(),
                          file.has_colours ? ", with a colour each" : "", material_texts(file));
     },
     [](const BakedHeader& file) {
       return fmt::format("keeps variances down to {:.1e}",
                          1.0 / static_cast<double>(lobe_family(file.representation).kappa_max(file.encoding)));
     }},
    {Representation::kMoments,
     [](const std::string&, const BakedHeader& file) {
       return fmt::format("mean normal, first and second moments of slopes{}{}",
                          file.has_colours ? ", mean colour" : "", material_texts(file));
     },
     [](const BakedHeader& file) {
       return fmt::format("at a slope b, stores deviations of slopes as small as {:.4f} b",
                          static_cast<double>(least_slope_deviation(file.encoding)));
     }},
    {Representation::kSh,
     [](const std::string& path, const BakedHeader& file) {
       const int order = read_sh_header(path).order;
       return fmt::format("spherical harmonics to order {}: {} coefficients in {} textures{}{}", order,
                          sh_coefficient_count(order), sh_part_count(order), file.has_colours ? ", mean colour" : "",
                          material_texts(file));
     },
     [](const BakedHeader& file) {
       return std::string(file.encoding == StorageEncoding::kHalf
                              ? "rounds each coefficient by at most 2^-11 of its value"
                              : "loses nothing");
     }},
};

const InfoKind& info_kind(Representation representation) {
  for (const InfoKind& kind : kInfoKinds)
    if (kind.representation == representation) return kind;
  MULTUM_CHECK(false);
  return kInfoKinds[0];
}

// Describes the size on the GPU, compared with BC5 and BC4 textures of the same map.
std::string on_the_gpu(std::uint64_t bytes, const BakedHeader& file) {
  const std::uint64_t by_default = default_gpu_bytes(file.width, file.height);
  return fmt::format("on the GPU      {}{}, {:.1f} times the {} of a BC5 normal and a BC4 roughness\n",
                     size_text(bytes), file.first_level > 0 ? " besides the normal map itself" : "",
                     static_cast<double>(bytes) / static_cast<double>(by_default), size_text(by_default));
}

// Returns the properties that the bake found in its source files. The result is empty for files that earlier versions
// wrote.
std::string reading_text(const std::string& reading) {
  const nlohmann::json json = nlohmann::json::parse(reading, nullptr, false);
  if (!json.is_object()) return "";
  std::string text;
  const auto line = [&](const char* label, const nlohmann::json& value) {
    text += fmt::format("{:<16}{}\n", label, value.is_string() ? value.get<std::string>() : value.dump());
  };
  constexpr std::pair<const char*, const char*> kLines[] = {{"format", "source format"}, {"found", "read as"},
                                                            {"because", "because"},      {"wrap", "wrap of source"},
                                                            {"albedo", "albedo"},        {"roughness", "roughness"}};
  for (const auto& [key, label] : kLines)
    if (json.contains(key)) line(label, json.at(key));
  constexpr std::pair<const char*, const char*> kCounts[] = {
      {"unused_texels", "black texels, which are taken as unused"},
      {"nonfinite_repaired", "texels that are not finite"},
      {"zero_length_repaired", "texels of length 0"},
      {"below_horizon_repaired", "texels below the horizon"},
      {"albedo_clamped", "albedo texels without a colour"}};
  for (const auto& [key, label] : kCounts)
    if (json.contains(key)) line("repaired", fmt::format("{} {}", json.at(key).dump(), label));
  if (json.contains("doubts"))
    for (const nlohmann::json& doubt : json.at("doubts")) line("in doubt", doubt);
  return text;
}

int print_pyramid(const std::string& path) {
  const PyramidHeader file = read_pyramid_header(path);
  const BakedProvenance& from = file.map.provenance;
  std::string text = fmt::format("file            {}\n", path);
  text += fmt::format("representation  pyramid of {}\n", pyramid_kind_name(file.kind));
  text += fmt::format("size            {} x {}, {} levels, wrap {}, {}\n", file.map.width, file.map.height,
                      file.level_count(), wrap_mode_name(file.map.wrap_s), wrap_mode_name(file.map.wrap_t));
  text += fmt::format("encoding        {}\n", storage_encoding_name(file.map.encoding));
  text += fmt::format("on disk         {}\n", size_text(std::filesystem::file_size(path)));
  if (!from.source_hash.empty())
    text += fmt::format("source          {}, SHA-256 {}\n", from.source_name, from.source_hash);
  text += fmt::format("settings        {}\n", rounded_settings(from.settings));
  text += fmt::format("checksum        {}\nwritten by      {}\n", from.content_hash, from.software);
  write_shown(stdout, text);
  return 0;
}

void print_info_json(const std::string& path) {
  const std::optional<OrderedJson> field = packed_field_json(path);
  print_json(field ? *field : baked_file_json(path));
}

int print_info(const std::string& path) {
  if (const std::optional<std::string> text = packed_field_info(path)) {
    write_shown(stdout, *text);
    return 0;
  }
  if (is_pyramid_file(path)) return print_pyramid(path);
  const BakedHeader file = read_baked_header(path);
  const BakedProvenance& from = file.provenance;
  const InfoKind& kind = info_kind(file.representation);
  std::string text;
  text += fmt::format("file            {}\n", path);
  text +=
      fmt::format("representation  {}: {}\n", representation_info(file.representation).name, kind.texels(path, file));
  text += fmt::format("size            {} x {}, {}, wrap {}, {}\n", file.width, file.height,
                      levels_text(file.first_level, file.level_count()), wrap_mode_name(file.wrap_s),
                      wrap_mode_name(file.wrap_t));
  text += fmt::format("encoding        {}; {}\n", storage_encoding_name(file.encoding), kind.survives(file));
  text += fmt::format("on disk         {}\n", size_text(std::filesystem::file_size(path)));
  text += on_the_gpu(baked_gpu_bytes(path), file);
  text += fmt::format("source          {}, SHA-256 {}\n", from.source_name, from.file_hash());
  if (!from.source_tiles.empty())
    text += fmt::format("with its set    SHA-256 {} of the source and the data from other tiles\n", from.source_hash);
  text += reading_text(from.reading);
  text += fmt::format("settings        {}\n", rounded_settings(from.settings));
  text += fmt::format("checksum        {}\n", from.content_hash);
  text += fmt::format("written by      {}\n", from.software);
  text += measured_error(from.measured_error);
  write_shown(stdout, text);
  return 0;
}

// Returns the findings of verify about a baked file or a packed field.
std::vector<VerifyFinding> findings_of(const std::string& path, int threads) {
  const std::optional<std::vector<VerifyFinding>> of_field = packed_field_findings(path);
  return of_field ? *of_field : verify_baked(path, threads);
}

int run_verify(const std::string& path, const CommonOptions& common) {
  bool all_passed = true;
  OrderedJson findings = OrderedJson::array();
  for (const VerifyFinding& finding : findings_of(path, apply(common))) {
    findings.push_back({{"check", finding.check}, {"passed", finding.passed}, {"detail", finding.detail}});
    if (!common.json)
      print_shown(stdout, "%-6s %-10s %s\n", finding.passed ? "ok" : "FAILED", finding.check.c_str(),
                  finding.detail.c_str());
    all_passed = all_passed && finding.passed;
  }
  if (common.json) print_json({{"file", path_json(path)}, {"passed", all_passed}, {"findings", findings}});
  if (!all_passed) throw Error(ErrorCode::kVerification, path + ": verification failed");
  return 0;
}

nlohmann::ordered_json device_json(const DeviceInfo& d) {
  return {{"index", d.index},
          {"name", d.name},
          {"platform", d.platform},
          {"driver", d.driver},
          {"version", d.version},
          {"is_cpu", d.is_cpu},
          {"shares_memory", d.shares_memory},
          {"rounds_when_asked", d.rounds_when_asked},
          {"has_atomic_longs", d.has_atomic_longs},
          {"compute_units", d.compute_units},
          {"work_group_max", d.work_group_max},
          {"local_bytes", d.local_bytes},
          {"memory_bytes", d.memory_bytes},
          {"buffer_bytes_max", d.buffer_bytes_max}};
}

int run_devices(const std::string& report, bool prints_json) {
  const std::vector<DeviceInfo> devices = list_devices();
  OrderedJson json = OrderedJson::array();
  for (const DeviceInfo& d : devices) json.push_back(device_json(d));
  if (!report.empty()) {
    check_writable(report);
    write_text_file(report, json_text(json, 2) + "\n");
  }
  if (prints_json) print_json(json);
  if (devices.empty())
    throw Error(ErrorCode::kEnvironment,
                "no OpenCL device found; expected a driver such as PoCL (Debian package pocl-opencl-icd)");
  if (prints_json) return 0;
  for (const DeviceInfo& d : devices)
    print_shown(stdout, "%d  %s  (%s, driver %s, %s, %.1f GiB, buffers up to %.1f GiB)\n", d.index, d.name.c_str(),
                d.platform.c_str(), d.driver.c_str(), d.is_cpu ? "CPU" : "GPU",
                static_cast<double>(d.memory_bytes) / (1u << 30), static_cast<double>(d.buffer_bytes_max) / (1u << 30));
  return 0;
}

}  // namespace

void add_info_command(CLI::App& app, int* exit_code) {
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  CLI::App* info = app.add_subcommand("info", "print the header of a baked file or a packed field");
  info->add_option("file", *path, "baked file, *.ndf.exr, or packed field, *.mpt")->required();
  add_json_option(*info, *json);
  info->callback([path, json, exit_code] {
    if (*json) print_info_json(*path);
    *exit_code = *json ? 0 : print_info(*path);
  });
}

void add_verify_command(CLI::App& app, int* exit_code) {
  auto path = std::make_shared<std::string>();
  auto common = std::make_shared<CommonOptions>();
  CLI::App* verify =
      app.add_subcommand("verify",
                         "check the structure, finite values, sums and checksums of a baked file or a packed"
                         " field");
  verify->add_option("file", *path, "baked file, *.ndf.exr, or packed field, *.mpt")->required();
  add_common_options(*verify, *common);
  verify->callback([path, common, exit_code] { *exit_code = run_verify(*path, *common); });
}

void add_devices_command(CLI::App& app, int* exit_code) {
  CLI::App* devices = app.add_subcommand("devices", "list the OpenCL devices of this machine");
  auto report = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  devices->add_option("--report", *report, "write the properties of the devices to this file as JSON");
  add_json_option(*devices, *json);
  devices->callback([report, json, exit_code] { *exit_code = run_devices(*report, *json); });
}

}  // namespace multum
