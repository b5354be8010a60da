// SPDX-License-Identifier: Apache-2.0
#include "host/fields/player/player_output.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/inferred/field_files.h"
#include "host/fields/player/player_files.h"
#include "host/fields/player/scene_glb.h"
#include "host/formats/mesh/object_mesh.h"
#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/html/html_page.h"
#include "host/foundation/html/page_script.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kGeometryName = "geometry.glb";
constexpr const char* kWasmName = "packed_field.wasm";

// The modules in the order of their imports. For a single page they are joined into one script, so no two modules may
// use the same top-level name.
constexpr std::array kPageModules = {
    "error_text.js",    "next_frame.js",        "byte_source.js",        "checksum.js",
    "mpt_file.js",      "field_description.js", "matrices.js",           "glb.js",
    "texture_store.js", "player_gl.js",         "decoding_pool.js",      "drawing_quality.js",
    "field_player.js",  "recorded_path.js",     "parameter_controls.js", "player.js"};
constexpr std::array kWorkerModules = {"packed_field.js", "error_text.js", "chunk_head.js", "decoding_worker.js"};

/// Returns a file of the player. The file packed_field.mjs is published with the ending .js, because not all servers
/// know .mjs.
std::string_view player_file(const std::string& name) {
  if (name == "packed_field.js") return player_module_files().at("packed_field.mjs");
  if (name == kWasmName) return player_module_files().at(name);
  return player_web_files().at(name);
}

std::string file_bytes(const std::string& path) {
  RegularFileStream stream(path);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw Error(ErrorCode::kInput, path + ": cannot be read");
  return bytes;
}

/// Returns the objects that the field draws, from the scene file that it names.
std::string geometry_of(const std::string& field, const PlayerOutput& output) {
  const PackedFieldFile file(field);
  const InferredManifest& manifest = file.description().field;
  const std::string folder = fs::path(field).parent_path().string();
  if (output.check_geometry) output.check_geometry(geometry_path(manifest, folder));
  const std::string path = checked_geometry(manifest, folder);
  std::set<std::string> drawn;
  for (const InferredObject& object : manifest.objects) drawn.insert(object.mesh);
  std::vector<ObjectMesh> objects = read_object_meshes(path, manifest.uv_set);
  std::erase_if(objects, [&](const ObjectMesh& object) { return drawn.count(object.name) == 0; });
  if (objects.size() != drawn.size())
    throw Error(ErrorCode::kInput, fmt::format("{}: has only {} of the {} objects that the field draws", path,
                                               objects.size(), drawn.size()));
  return scene_glb(objects, manifest.uv_set);
}

/// Joins modules into one script.
template <std::size_t kCount>
std::string joined(const std::array<const char*, kCount>& names) {
  std::string script;
  for (const char* name : names) script += plain_script(player_file(name));
  check_script(script);
  return script;
}

void replace(std::string& text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  MULTUM_CHECK(at != std::string::npos);
  text.replace(at, what.size(), with);
}

std::string configured_page(const ordered_json& configuration, const std::string& blocks) {
  std::string html(player_file("player.html"));
  const std::string block = R"(<script type="application/json" id="player-config">{}</script>)";
  replace(html, block,
          R"(<script type="application/json" id="player-config">)" + script_json(configuration) + "</script>" + blocks);
  return html;
}

std::string one_page(const std::string& name, const std::string& title, const std::string& field,
                     const std::string& geometry) {
  const auto block = [](const char* id, const std::string& content) {
    return fmt::format("\n<script type=\"text/plain\" id=\"{}\">{}</script>", id, content);
  };
  std::string html =
      configured_page({{"file", name}, {"geometry", kGeometryName}, {"title", title}},
                      block("data-field", encode_base64(field)) + block("data-geometry", encode_base64(geometry)) +
                          block("data-wasm", encode_base64(std::string(player_file(kWasmName)))) +
                          block("worker-source", joined(kWorkerModules)));
  replace(html, R"(<link rel="stylesheet" href="player.css">)",
          "<style>\n" + std::string(player_file("player.css")) + "</style>");
  replace(html, R"(<script type="module" src="player.js"></script>)",
          "<script type=\"module\">\n" + joined(kPageModules) + "</script>");
  return html;
}

void write_folder(const std::string& name, const std::string& title, const std::string& field,
                  const std::string& geometry, const std::string& folder) {
  make_folder(folder);
  const auto write = [&](const std::string& file, std::string_view bytes) {
    write_text_file((fs::path(folder) / file).string(), bytes);
  };
  for (const auto& [file, text] : player_web_files())
    if (file != "player.html") write(file, text);
  for (const char* file : {"packed_field.js", kWasmName}) write(file, player_file(file));
  write(kGeometryName, geometry);
  write(name, field);
  write("index.html", configured_page({{"file", name}, {"geometry", kGeometryName}, {"title", title}}, ""));
}

}  // namespace

void check_player_output(const PlayerOutput& output) {
  if (!output.is_asked_for()) return;
  if (player_module_files().count(kWasmName) == 0)
    throw Error(ErrorCode::kEnvironment,
                "this multum was built without the decoder for browsers, because its build found no compiler for "
                "WebAssembly. On Debian, run apt-get install clang lld wasi-libc libc++-14-dev-wasm32 "
                "libclang-rt-14-dev-wasm32, and build again");
  if (!output.page.empty() && fs::path(output.page).extension() != ".html")
    throw Error(ErrorCode::kUsage, output.page + ": expected the name of a page, *.html");
  if (!output.page.empty()) check_writable(output.page);
  if (!output.folder.empty() && fs::exists(output.folder) && !fs::is_directory(output.folder))
    throw Error(ErrorCode::kUsage, output.folder + ": is a file; expected a folder for the player");
}

void write_player(const std::string& field, const PlayerOutput& output) {
  if (!output.is_asked_for()) return;
  check_player_output(output);
  const std::string geometry = geometry_of(field, output), bytes = file_bytes(field);
  const std::string name = fs::path(field).filename().string(), title = text_of_path(fs::path(field).stem().string());
  if (!output.folder.empty()) write_folder(name, title, bytes, geometry, output.folder);
  if (output.page.empty()) return;
  if (bytes.size() + geometry.size() > kPlayerPageBytesMax)
    throw Error(ErrorCode::kUsage, fmt::format("{}: the field and its geometry have {} bytes, but a page can hold at "
                                               "most {}; expected a folder for the player instead of a page",
                                               output.page, bytes.size() + geometry.size(), kPlayerPageBytesMax));
  write_text_file(output.page, one_page(name, title, bytes, geometry));
}

}  // namespace multum
