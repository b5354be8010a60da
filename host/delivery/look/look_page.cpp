// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/look/look_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/delivery/export/export_job.h"
#include "host/delivery/export/lobes/lobe_export.h"
#include "host/delivery/look/look_files.h"
#include "host/formats/asset/baked_file.h"
#include "host/formats/brdf/ggx_lobe.h"
#include "host/formats/image/colour_map.h"
#include "host/formats/image/files/png_writer.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/html/html_page.h"
#include "host/foundation/html/page_script.h"

namespace multum {
namespace {

std::string base64_of_file(const std::string& path) { return encode_base64(bytes_of_file(path)); }

// Throws Error for a map that the page cannot show.
void check_map(const LookMap& map, const BakedHeader& header, bool same_source) {
  if (header.has_roughness)
    refuse_file(
        map.input,
        "found roughness in its lobes, expected none, because the page uses one base roughness for the whole surface");
  if (header.width > kLookSideMax || header.height > kLookSideMax)
    refuse_file(
        map.input,
        fmt::format("found a map of {} x {}, expected sides of at most {}, because the page contains the whole map",
                    header.width, header.height, kLookSideMax));
  if (map.source.empty() && header.first_level > 0)
    refuse_file(map.input,
                fmt::format("found only levels from {} on, expected level 0 too, or the normal map (--source)",
                            header.first_level));
  if (map.source.empty() || header.provenance.source_hash.empty() ||
      hash_file(map.source) == header.provenance.file_hash())
    return;
  const std::string found =
      fmt::format("is not the file that {} was baked from ({})", map.input, header.provenance.source_name);
  if (same_source) throw Error(ErrorCode::kInput, fmt::format("{}: {}, or has changed since", map.source, found));
  log_warning(map.source, found + ": the page may compare two different maps");
}

std::vector<BakedHeader> checked_headers(const LookJob& job) {
  std::vector<BakedHeader> headers;
  std::int64_t texels = 0;
  for (const LookMap& map : job.maps) {
    headers.push_back(read_baked_header(map.input));
    check_map(map, headers.back(), job.same_source);
    texels += std::int64_t{headers.back().width} * headers.back().height;
  }
  if (texels > kLookTexelsMax)
    throw Error(ErrorCode::kInput, fmt::format("found maps with {} texels in total, expected at most {} (four maps of "
                                               "{} x {}), because the page contains all maps",
                                               texels, kLookTexelsMax, kLookSideMax, kLookSideMax));
  return headers;
}

// Returns texts in the order of runtime_gl/shaders/common/reflection.glsl.
nlohmann::ordered_json shader_texts() {
  const auto joined = [](std::initializer_list<const char*> names) {
    std::string text;
    for (const char* name : names) text += look_shader_files().at(name);
    return text;
  };
  const std::string common = joined({"common/movmf_shading.glsl", "common/texture_filter.glsl",
                                     "common/reflection.glsl", "brdf/cook_torrance.glsl", "brdf/ggx.glsl"});
  return {{"common", common},
          {"lobeBrdf", joined({"brdf/ggx_lobe.glsl"})},
          {"lobes", joined({"surface/lobes.glsl", "surface/movmf.glsl"})},
          {"lights", joined({"light/lights.glsl"})}};
}

std::string table_base64() {
  std::string bytes;
  for (const std::uint16_t half : ggx_lobe_table()) {
    bytes.push_back(static_cast<char>(half & 0xff));
    bytes.push_back(static_cast<char>(half >> 8));
  }
  return encode_base64(bytes);
}

void put_in_place(std::string& page, std::string_view mark, const std::string& text) {
  const std::size_t at = page.find(mark);
  MULTUM_CHECK(at != std::string::npos);
  page.replace(at, mark.size(), text);
}

std::string look_page(const nlohmann::ordered_json& data) {
  const auto file = [](const char* name) { return std::string(look_page_files().at(name)); };
  std::string script;
  for (const char* name : {"error_text.js", "next_frame.js", "matrices.js", "glb.js", "three/bc5.js"})
    script += plain_script(look_module_files().at(name));
  for (const char* name : {"look_glb.js", "look_gltf.js", "look_textures.js", "look_shapes.js", "look_light.js",
                           "look_gl.js", "look_reference.js", "look_picture.js", "look_drops.js", "look.js"})
    script += file(name);
  const std::string worker = plain_script(look_module_files().at("error_text.js")) + file("look_exr.js");
  check_script(script);
  check_script(worker);
  std::string page = file("look.html");
  put_in_place(page, "/*LOOK-STYLE*/", file("look.css"));
  put_in_place(page, "/*LOOK-WORKER*/", worker);
  put_in_place(page, "/*LOOK-SCRIPT*/", script);
  put_in_place(page, R"(<script type="application/json" id="look-data">{}</script>)",
               R"(<script type="application/json" id="look-data">)" + script_json(data) + "</script>");
  return page;
}

// Returns an albedo as a PNG of 8 bits, which every browser decodes.
std::string albedo_base64(const LookMap& map, const BakedHeader& header, const std::string& stem, int threads) {
  const ColourMap colours = read_albedo_map(map.albedo, header.width, header.height, threads);
  Png8Image image;
  image.width = header.width;
  image.height = header.height;
  for (std::size_t i = 0; i < colours.r.size(); ++i)
    for (const float value : {colours.r[i], colours.g[i], colours.b[i]})
      image.interleaved.push_back(
          static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(std::min(1.0, static_cast<double>(value))))));
  write_png8(stem + "_albedo.png", image);
  return base64_of_file(stem + "_albedo.png");
}

// Returns the lobes and the one-lobe export. The names of temporary files begin with `stem`.
nlohmann::ordered_json map_data(const LookMap& map, const BakedHeader& header, const LookJob& job,
                                const std::string& stem, Device& device, Progress* progress) {
  LobeExportJob lobes{map.input, stem + "_lobes.ktx2", ""};
  lobes.threads = job.threads;
  export_lobes(lobes, device, nullptr);
  ExportJob material;
  material.input = map.source.empty() ? map.input : map.source;
  material.output = stem + ".ktx2";
  material.reading = parse_reading_settings(header.provenance.settings);
  material.reading.wrap_s = header.wrap_s;
  material.reading.wrap_t = header.wrap_t;
  material.lobe.base_roughness = static_cast<double>(static_cast<float>(map.base_roughness));
  material.texels = MaterialTexels::kRg8;
  material.packing = MaterialPacking::kSeparate;
  material.measure = false;
  material.threads = job.threads;
  const ExportReport report = export_file(material, device, progress);
  if (report.width != header.width || report.height != header.height)
    refuse_file(map.source, fmt::format("found {} x {} texels, expected {} x {} as in the map that {} was baked from",
                                        report.width, report.height, header.width, header.height, map.input));
  nlohmann::ordered_json data = {
      {"title", text_of_path(map.title.empty() ? std::filesystem::path(map.input).filename().string() : map.title)},
      {"about", fmt::format("{} with GGX", text_of_path(header.provenance.source_name))},
      {"roughness", map.base_roughness},
      {"metalness", map.metalness},
      {"lobes", base64_of_file(lobes.output)},
      {"normals", base64_of_file(stem + "_normal.ktx2")},
      {"exportedRoughness", base64_of_file(stem + "_roughness.ktx2")}};
  if (!map.albedo.empty()) data["colours"] = albedo_base64(map, header, stem, job.threads);
  return data;
}

}  // namespace

void write_look_page(const LookJob& job, Device& device, Progress* progress) {
  MULTUM_CHECK(!job.maps.empty());
  std::vector<std::string> inputs;
  for (const LookMap& map : job.maps)
    for (const std::string& file : {map.input, map.source, map.albedo})
      if (!file.empty()) inputs.push_back(file);
  check_paths_differ(inputs, {job.output});
  check_writable(job.output);
  const std::vector<BakedHeader> headers = checked_headers(job);
  const std::unique_ptr<WorkFolder> folder = WorkFolder::take(partial_folder_of(job.output));
  if (!folder) throw Error(ErrorCode::kEnvironment, job.output + ": is being written by another process");
  folder->clear();
  nlohmann::ordered_json data = {{"shaders", shader_texts()}, {"ggxTable", table_base64()}};
  for (std::size_t i = 0; i < job.maps.size(); ++i)
    data["maps"].push_back(
        map_data(job.maps[i], headers[i], job, fmt::format("{}/map{}", folder->path(), i), device, progress));
  write_text_file(job.output, look_page(data));
}

}  // namespace multum
