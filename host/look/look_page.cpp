// SPDX-License-Identifier: Apache-2.0
#include "host/look/look_page.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/asset/baked_file.h"
#include "host/base/base64.h"
#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/byte_file.h"
#include "host/base/files/content_hash.h"
#include "host/base/files/output_paths.h"
#include "host/base/files/partial_folder.h"
#include "host/base/log.h"
#include "host/brdf/ggx_lobe.h"
#include "host/export/export_job.h"
#include "host/export/lobes/lobe_export.h"
#include "host/html/html_page.h"
#include "host/image/normals/reading_settings.h"
#include "host/look/look_files.h"

namespace multum {
namespace {

std::string base64_of_file(const std::string& path) { return encode_base64(bytes_of_file(path)); }

BakedHeader checked_header(const LookJob& job) {
  BakedHeader header = read_baked_header(job.input);
  if (header.has_roughness)
    refuse_file(job.input, "found roughness in its lobes, expected none: the page has one base roughness");
  if (header.width > kLookSideMax || header.height > kLookSideMax)
    refuse_file(job.input, fmt::format("found a map of {} x {}, expected sides of at most {}: the page holds it whole",
                                       header.width, header.height, kLookSideMax));
  if (!header.provenance.source_hash.empty() && hash_file(job.source) != header.provenance.source_hash) {
    const std::string found =
        fmt::format("is not the file that {} was baked from ({})", job.input, header.provenance.source_name);
    if (job.same_source) throw Error(ErrorCode::kInput, fmt::format("{}: {}, or has changed since", job.source, found));
    log_warning(fmt::format("{}: {}: the page may compare two maps", job.source, found));
  }
  return header;
}

// Texts in the order of runtime_gl/shaders/common/reflection.glsl.
nlohmann::ordered_json shader_texts() {
  const auto joined = [](std::initializer_list<const char*> names) {
    std::string text;
    for (const char* name : names) text += look_shader_files().at(name);
    return text;
  };
  const std::string common = joined({"common/movmf_shading.glsl", "common/texture_filter.glsl",
                                     "common/reflection.glsl", "brdf/cook_torrance.glsl", "brdf/ggx.glsl"});
  return {{"oneNormal", common},
          {"lobes", common + joined({"brdf/ggx_lobe.glsl", "surface/lobes.glsl", "surface/movmf.glsl"})},
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
  std::string script = file("look_textures.js") + file("look_gl.js") + file("look.js");
  MULTUM_CHECK(script.find("</script") == std::string::npos && script.find("<!--") == std::string::npos);
  std::string page = file("look.html");
  put_in_place(page, "/*LOOK-STYLE*/", file("look.css"));
  put_in_place(page, "/*LOOK-SCRIPT*/", script);
  put_in_place(page, R"(<script type="application/json" id="look-data">{}</script>)",
               R"(<script type="application/json" id="look-data">)" + script_json(data) + "</script>");
  return page;
}

}  // namespace

void write_look_page(const LookJob& job, Device& device, Progress* progress) {
  check_paths_differ({job.input, job.source}, {job.output});
  check_writable(job.output);
  const BakedHeader header = checked_header(job);
  const std::unique_ptr<PartialFolder> folder = PartialFolder::take(job.output);
  if (!folder) throw Error(ErrorCode::kEnvironment, job.output + ": is being written by another process");
  folder->clear();

  LobeExportJob lobes{job.input, folder->path() + "/lobes.ktx2", ""};
  lobes.threads = job.threads;
  export_lobes(lobes, device, nullptr);
  ExportJob material;
  material.input = job.source;
  material.output = folder->path() + "/one.ktx2";
  material.reading = parse_reading_settings(header.provenance.settings);
  material.reading.wrap_s = header.wrap_s;
  material.reading.wrap_t = header.wrap_t;
  material.lobe.base_roughness = static_cast<float>(job.base_roughness);
  material.texels = MaterialTexels::kRg8;
  material.has_roughness_alone = true;
  material.measure = false;
  material.threads = job.threads;
  const ExportReport report = export_file(material, device, progress);
  if (report.width != header.width || report.height != header.height)
    refuse_file(job.source, fmt::format("found {} x {} texels, expected {} x {}, of which {} was baked", report.width,
                                        report.height, header.width, header.height, job.input));
  const std::string name = std::filesystem::path(job.input).filename().string();
  const nlohmann::ordered_json data = {
      {"title", name},
      {"about", fmt::format("{}, GGX of roughness {:.2g}", header.provenance.source_name, job.base_roughness)},
      {"baseRoughness", job.base_roughness},
      {"diffuse", 0.1},
      {"specular", 1.0},
      {"f0", 0.04},
      {"shaders", shader_texts()},
      {"ggxTable", table_base64()},
      {"lobes", base64_of_file(lobes.output)},
      {"normals", base64_of_file(folder->path() + "/one_normal.ktx2")},
      {"roughness", base64_of_file(folder->path() + "/one_roughness.ktx2")}};
  write_text_file(job.output, look_page(data));
}

}  // namespace multum
