// SPDX-License-Identifier: Apache-2.0
// Implements multum shaders, which writes the shading of lobes for engines. The output consists of one file per
// language, textures, and the npm package @multum/three.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "host/delivery/export/texture_file.h"
#include "host/formats/brdf/ggx_lobe.h"
#include "host/formats/sampling/blue_noise.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"
#include "tools/multum/shading_files.h"

namespace multum {
namespace {

struct ShadersOptions {
  CommonOptions common;
  std::string folder;
};

std::string json_string(std::string_view text) { return nlohmann::json(std::string(text)).dump(); }

/// Returns a module for three.js and other programs that accept GLSL as a string.
std::string javascript_module() {
  const auto& fetching = lobe_texture_shaders();
  std::string numbers;
  for (const std::uint16_t half : ggx_lobe_table()) numbers += fmt::format("{}{}", numbers.empty() ? "" : ",", half);
  return fmt::format(
      "// SPDX-License-Identifier: Apache-2.0\n"
      "// Shades multum's lobes in three.js, fetches textures of multum export --lobes, and contains the table that\n"
      "// GGX needs: half floats, RGBA, linear filter, clamped.\n"
      "export const lobesGlsl = {};\n"
      "export const lobeTextureGlsl = {} +\n  {};\n"
      "export const ggxLobeTable = {{ width: {}, height: {}, data: new Uint16Array([{}]) }};\n",
      json_string(shading_files().at("multum_lobes.glsl")), json_string(fetching.at("common/texture_filter.glsl")),
      json_string(fetching.at("surface/lobes.glsl")), kGgxLobeTableSide, kGgxLobeTableSide, numbers);
}

/// Writes a texture with one level.
void write_texture(const std::string& path, TexelFormat format, int side, const void* texels) {
  const auto file = make_ktx2_file(path, {format, side, side, 1});
  file->write_rows(0, side, texels);
  file->finish();
}

int run_shaders(const ShadersOptions& o) {
  apply(o.common);
  const std::filesystem::path folder(o.folder), package = folder / "three";
  make_folder(package.string());
  for (const auto& [name, text] : shading_files()) write_text_file((folder / name).string(), text);
  for (const auto& [name, text] : three_package_files()) write_text_file((package / name).string(), text);
  for (const std::filesystem::path& place : {folder, package})
    write_text_file((place / "multum_lobes.js").string(), javascript_module());
  write_texture((folder / "ggx_lobe_table.ktx2").string(), TexelFormat::kRgba16f, kGgxLobeTableSide,
                ggx_lobe_table().data());
  write_texture((folder / "blue_noise.ktx2").string(), TexelFormat::kRgba8, kBlueNoiseSide, blue_noise().data());
  if (o.common.json) print_json({{"output", path_json(o.folder)}});
  if (!prints_text(o.common)) return 0;
  print_shown(
      stdout,
      "%s: written: multum_lobes in GLSL, HLSL, Metal, WGSL and JavaScript, ggx_lobe_table.ktx2, blue_noise.ktx2, "
      "and in three the npm package @multum/three\n",
      o.folder.c_str());
  return 0;
}

}  // namespace

void add_shaders_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ShadersOptions>();
  CLI::App* command = app.add_subcommand("shaders",
                                         "write the shading code of lobes in GLSL, HLSL, Metal, WGSL and JavaScript, "
                                         "and @multum/three for three.js (docs/how-to/draw_lobes.md)");
  command->add_option("-o,--output", options->folder, "folder to write to")->required();
  add_common_options(*command, options->common);
  command->callback([options, exit_code] { *exit_code = run_shaders(*options); });
}

}  // namespace multum
