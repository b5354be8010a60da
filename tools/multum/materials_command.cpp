// SPDX-License-Identifier: Apache-2.0
// Implements multum materials, which lists the materials of a glTF model and writes a manifest for baking its normal
// maps.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/formats/image/image_reader.h"
#include "host/formats/mesh/gltf_material.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

struct MaterialsOptions {
  std::string model, folder;
  bool force = false, json = false;
};

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) out += fmt::format("\\u{:04x}", static_cast<int>(c));
    else out += c;
  }
  return out + "\"";
}

std::string image_text(const GltfMaterials& model, const std::optional<GltfTexture>& texture) {
  if (!texture) return "none";
  const GltfImage& image = model.images[static_cast<std::size_t>(texture->image)];
  return image.file.empty() ? fmt::format("{}.{} (inside the file)", image.name, image.extension) : image.file;
}

void print_materials(const GltfMaterials& model) {
  for (const GltfMaterial& m : model.materials) {
    write_shown(stdout, fmt::format("{}\n  normal map    {}", m.name, image_text(model, m.normal)));
    if (m.normal)
      write_shown(stdout, fmt::format(", TEXCOORD_{}, wrap {},{}, scale {:g}", m.normal->uv_set, m.normal->wrap_s,
                                      m.normal->wrap_t, m.normal_scale));
    write_shown(stdout, fmt::format("\n  base colour   {:g},{:g},{:g} times {}\n", m.base_colour.r, m.base_colour.g,
                                    m.base_colour.b, m.colour ? image_text(model, m.colour) : "1"));
    write_shown(stdout, fmt::format("  metallic      {:g}{}\n  roughness     {:g}{}\n", m.metallic,
                                    m.metallic_roughness ? " times its texture's mean" : "", m.roughness,
                                    m.metallic_roughness ? " times its texture's mean" : ""));
  }
}

struct Size {
  int width, height;
  bool operator==(const Size&) const = default;
};

Size size_of(const std::string& image) {
  const RawImageInfo info = ImageReader(image, {}).info();
  return {info.width, info.height};
}

std::string map_text(const GltfMaterials& model, const GltfMaterial& material, const std::string& folder,
                     const std::string& output) {
  const auto path_of = [&](const GltfTexture& texture) {
    return extract_image(model.images[static_cast<std::size_t>(texture.image)], folder);
  };
  const auto relative = [&](const std::string& path) {
    return quoted(text_of_path(fs::relative(fs::absolute(path), fs::absolute(folder)).generic_string()));
  };
  const std::string normal = path_of(*material.normal);
  std::string text = fmt::format("\n[[map]]  # {}\ninput = {}\noutput = {}\n", quoted(material.name), relative(normal),
                                 quoted(output));
  text += fmt::format("swrap = \"{}\"\ntwrap = \"{}\"\n", material.normal->wrap_s, material.normal->wrap_t);
  if (material.normal_scale != 1.0f)
    text += fmt::format("normal_scale = {:.9g}\n", static_cast<double>(material.normal_scale));
  if (!material.colour) return text;
  const std::string colour = path_of(*material.colour);
  if (material.colour->uv_set != material.normal->uv_set)
    return text + fmt::format("# no albedo: {} uses TEXCOORD_{}\n", relative(colour), material.colour->uv_set);
  if (!(size_of(colour) == size_of(normal)))
    return text + fmt::format("# no albedo, because {} has a different size\n", relative(colour));
  return text + fmt::format("albedo = {}\n", relative(colour));
}

OrderedJson image_json(const GltfMaterials& model, const std::optional<GltfTexture>& texture) {
  if (!texture) return nullptr;
  const GltfImage& image = model.images[static_cast<std::size_t>(texture->image)];
  OrderedJson json = {
      {"name", image.name}, {"uv_set", texture->uv_set}, {"wrap_s", texture->wrap_s}, {"wrap_t", texture->wrap_t}};
  if (!image.file.empty()) json["file"] = path_json(image.file);
  return json;
}

OrderedJson materials_json(const GltfMaterials& model) {
  OrderedJson rows = OrderedJson::array();
  for (const GltfMaterial& m : model.materials)
    rows.push_back({{"name", m.name},
                    {"normal", image_json(model, m.normal)},
                    {"normal_scale", m.normal_scale},
                    {"base_colour", {m.base_colour.r, m.base_colour.g, m.base_colour.b}},
                    {"colour", image_json(model, m.colour)},
                    {"metallic", m.metallic},
                    {"roughness", m.roughness},
                    {"metallic_roughness", image_json(model, m.metallic_roughness)}});
  return rows;
}

// Writes maps.toml. Returns its path and the number of maps in it.
std::pair<std::string, std::size_t> write_manifest(const MaterialsOptions& o, const GltfMaterials& model) {
  const auto has_map = [](const GltfMaterial& material) { return material.normal.has_value(); };
  if (std::none_of(model.materials.begin(), model.materials.end(), has_map))
    throw Error(ErrorCode::kInput, o.model + ": found no material with a normal map, expected one to bake");
  const std::string manifest = o.folder + "/maps.toml";
  if (fs::exists(manifest) && !o.force)
    throw Error(ErrorCode::kUsage, manifest + ": already exists; --force overwrites it");
  make_folder(o.folder);
  std::string text = fmt::format(
      "# The normal maps of {}, made by multum materials. Bake them: multum bake --manifest "
      "maps.toml\n\n[defaults]\nbumpformat = \"normal\"\ngreen = \"up\"  # as glTF defines it\nunsigned = true\n",
      quoted(text_of_path(fs::path(o.model).filename().string())));
  std::string view = fmt::format("multum-view model {} -o picture.png", o.model);
  std::size_t count = 0;
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    const GltfMaterial& material = model.materials[i];
    if (!material.normal) continue;
    const std::string output = fmt::format("{}_{}.ndf.exr", i, safe_file_name(material.name));
    text += map_text(model, material, o.folder, output);
    view += fmt::format(" --material {}={}/{}", quoted(material.name), o.folder, output);
    ++count;
  }
  write_text_file(manifest, text);
  if (!o.json)
    write_shown(stdout,
                fmt::format("\n{}: {} maps\n  multum bake --manifest {}\n  {}\n", manifest, count, manifest, view));
  return {manifest, count};
}

int run_materials(const MaterialsOptions& o) {
  const GltfMaterials model = read_gltf_materials(o.model);
  if (model.materials.empty()) throw Error(ErrorCode::kInput, o.model + ": found no materials, expected at least one");
  OrderedJson json = {{"model", path_json(o.model)}, {"materials", materials_json(model)}};
  if (!o.json) print_materials(model);
  if (!o.folder.empty()) {
    const auto [manifest, count] = write_manifest(o, model);
    json["manifest"] = path_json(manifest);
    json["maps"] = count;
  }
  if (o.json) print_json(json);
  return 0;
}

}  // namespace

void add_materials_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<MaterialsOptions>();
  CLI::App* materials = app.add_subcommand(
      "materials", "list the materials of a glTF model, and write a manifest that bakes its normal maps");
  materials->add_option("model", options->model, "model to read, *.gltf or *.glb")->required();
  materials->add_option("-o,--output", options->folder,
                        "folder for maps.toml and for the images inside the model; a missing folder is created");
  materials->add_flag("--force", options->force, "overwrite an existing maps.toml");
  add_json_option(*materials, options->json);
  add_decoding_option(*materials);
  materials->callback([options, exit_code] { *exit_code = run_materials(*options); });
}

}  // namespace multum
