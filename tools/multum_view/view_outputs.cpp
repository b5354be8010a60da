// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/view_outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>

#include "host/formats/brdf/measured_brdf.h"
#include "host/formats/image/material_maps.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/shown_text.h"
#include "runtime_gl/render/contact_sheet.h"
#include "runtime_gl/render/picture_error.h"
#include "tools/multum_view/animated_view.h"
#include "tools/multum_view/view_inputs.h"
#include "tools/multum_view/write_image.h"

namespace multum {
namespace {

bool has_reference(const std::vector<NamedPicture>& pictures) { return pictures[0].name == "reference"; }

/// Returns the name of a picture on a sheet.
std::string shown_name_of(const std::string& name) {
  static const std::map<std::string, std::string> kNames = {
      {"mip", "averaged normals"}, {"toksvig", "Toksvig"}, {"lean-jacobian", "LEAN"}, {"lean", "LEAN (no jacobian)"}};
  const auto found = kNames.find(name);
  return found == kNames.end() ? name : found->second;
}

/// Composes a sheet. The pictures are in the first row. If there is a reference, their errors are in the second row.
gl::FloatImage compose(const std::vector<NamedPicture>& pictures, float exposure) {
  std::vector<std::vector<gl::SheetCell>> rows(has_reference(pictures) ? 2 : 1);
  for (const NamedPicture& one : pictures) {
    rows[0].push_back({shown_name_of(one.name), shown_image(one)});
    if (!has_reference(pictures)) continue;
    const gl::FloatImage& reference = pictures[0].picture.image;
    if (&one == &pictures[0]) {
      rows[1].push_back(
          {"", gl::difference_legend(reference.width, reference.height, gl::kDifferenceGain, 1.0f / exposure)});
      continue;
    }
    const double error = gl::picture_error(one.picture.image, reference).relative_l1;
    rows[1].push_back({fmt::format("error {:.1f} %", 100.0 * error),
                       gl::difference_image(one.picture.image, reference, gl::kDifferenceGain)});
  }
  return gl::make_contact_sheet(rows, 1.0f / exposure);
}

/// Returns the path of a single picture. `what` is its name, or its name and "_difference".
std::string picture_path(const OutputOptions& options, const std::string& what) {
  return options.pictures + "_" + what + options.path.substr(options.path.rfind('.'));
}

/// Writes every picture, and its difference from the reference, to its own file.
void write_each(const OutputOptions& options, const std::vector<NamedPicture>& pictures) {
  for (const NamedPicture& one : pictures) {
    write_picture(picture_path(options, one.name), shown_image(one), options.exposure);
    if (has_reference(pictures) && one.name != "reference")
      write_picture(picture_path(options, one.name + "_difference"),
                    gl::difference_image(one.picture.image, pictures[0].picture.image, gl::kDifferenceGain),
                    options.exposure);
  }
}

nlohmann::json colour_json(const glm::vec3& colour) { return {colour.x, colour.y, colour.z}; }

nlohmann::json brdf_json(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  nlohmann::json json = {{"brdf", family.name}};
  if (family.has_width()) json[std::string(family.members[0].key)] = width_of(brdf);
  if (family.has_f0()) json["f0"] = colour_json(brdf.f0);
  if (is_vmf_sum(brdf)) json["terms"] = brdf.term_count;
  if (family.is_file)
    json.update({{"name", brdf.measured->name}, {"factors_relative_error", brdf.measured->relative_error}});
  return json;
}

// The noise is not finite if the picture has only one sample per pixel, because noise cannot be measured from a single
// sample.
nlohmann::json noise_json(double noise) { return std::isfinite(noise) ? nlohmann::json(noise) : nlohmann::json(); }

std::string reference_line(const gl::Picture& reference) {
  const std::string noise =
      std::isfinite(reference.noise) ? fmt::format("{:.2f} % of itself", 100.0 * reference.noise) : "unknown";
  return fmt::format("the reference has {} samples per pixel, and its noise is {}\n", reference.sample_count, noise);
}

nlohmann::json filter_json(const ShadingOptions& shading) {
  if (shading.filter.is_drivers) return {{"of", "driver"}, {"anisotropy", shading.anisotropy}};
  nlohmann::json filter = {{"of", "multum"},
                           {"taps", shading.filter.taps},
                           {"level_bias", shading.level_bias.value_or(static_cast<float>(kLevelBiasDefault))},
                           {"shades_taps", shading.filter.shades_taps}};
  if (shading.evaluations) filter["evaluations"] = *shading.evaluations;
  return filter;
}

/// Adds the sheet and, if --pictures is given, each picture.
void add_pictures(const OutputOptions& options, const std::vector<std::string>& compared,
                  std::vector<std::string>& outputs) {
  outputs.push_back(options.path);
  if (options.pictures.empty()) return;
  const bool compares_reference = std::find(compared.begin(), compared.end(), "reference") != compared.end();
  std::vector<std::string> names = compared;
  names.insert(names.begin(), "multum");
  for (const std::string& name : names) {
    outputs.push_back(picture_path(options, name));
    if (compares_reference && name != "reference") outputs.push_back(picture_path(options, name + "_difference"));
  }
}

}  // namespace

void check_outputs(const MapOptions& options, const ViewScenes& scenes) {
  const PictureOptions& picture = options.picture;
  std::vector<std::string> outputs;
  if (options.animation.folder.empty()) {
    for (const View& view : views_of(picture, scenes.first))
      add_pictures(view.output, options.comparison.pictures, outputs);
  } else {
    make_folder(options.animation.folder);
    for (int frame = 0; frame < options.animation.frame_count; ++frame)
      outputs.push_back(frame_path(options.animation, frame));
  }
  for (const std::string& path : {picture.output.report, options.shaders, options.comparison.kept_reference})
    if (!path.empty()) outputs.push_back(path);
  const SourceOptions& source = options.source;
  check_paths_differ(
      {options.file, source.normals, source.albedo, parse_channel_file(source.roughness).path,
       parse_channel_file(source.gloss).path, source.weights, picture.surface.mesh, picture.light.environment},
      outputs);
  for (const std::string& path : outputs) check_writable(path);
}

void write_pictures(const OutputOptions& options, const std::vector<NamedPicture>& pictures) {
  const NamedPicture& baked = pictures[has_reference(pictures) ? 1 : 0];
  write_picture(options.path,
                options.is_alone || pictures.size() == 1 ? shown_image(baked) : compose(pictures, options.exposure),
                options.exposure);
  if (!options.pictures.empty()) write_each(options, pictures);
}

nlohmann::json print_table(const std::vector<NamedPicture>& pictures) {
  nlohmann::json rows = nlohmann::json::array();
  write_shown(stdout, fmt::format("{:14} {:>12} {:>10} {:>10}\n", "picture", "relative L1", "RMSE", "frame ms"));
  for (const NamedPicture& one : pictures) {
    nlohmann::json row = {{"name", one.name}, {"frame_time_ms", one.picture.frame_time_ms}};
    if (one.name != "reference")
      row.update({{"frame_processor_ms", one.picture.processor_time_ms}, {"frame_draw_ms", one.picture.draw_time_ms}});
    std::string l1 = "-";
    std::string rmse = "-";
    if (has_reference(pictures) && one.name != "reference") {
      const gl::PictureError error = gl::picture_error(one.picture.image, pictures[0].picture.image);
      row["relative_l1"] = error.relative_l1;
      row["rmse"] = error.rmse;
      l1 = fmt::format("{:.2f} %", 100.0 * error.relative_l1);
      rmse = fmt::format("{:.5f}", error.rmse);
    }
    if (one.name == "reference") {
      row["samples"] = one.picture.sample_count;
      row["noise_relative_l1"] = noise_json(one.picture.noise);
    }
    write_shown(stdout, fmt::format("{:10} {:>12} {:>10} {:>10.1f}\n", one.name, l1, rmse, one.picture.frame_time_ms));
    rows.push_back(row);
  }
  if (has_reference(pictures)) write_shown(stdout, reference_line(pictures[0].picture));
  return rows;
}

nlohmann::json draw_views(const PictureOptions& options, const gl::RenderScene& scene,
                          const std::function<std::vector<NamedPicture>(const gl::RenderScene& scene)>& draw) {
  nlohmann::json rows = nlohmann::json::array();
  for (const View& view : views_of(options, scene)) {
    const gl::Camera& camera = view.scene.camera;
    if (view.distance)
      write_shown(stdout, fmt::format("{}: {:g} times as far, {:.6g} away\n", view.output.path, *view.distance,
                                      glm::length(camera.eye - camera.target)));
    const std::vector<NamedPicture> pictures = draw(view.scene);
    for (nlohmann::json& row : print_table(pictures)) {
      if (view.distance) row["distance"] = *view.distance;
      rows.push_back(row);
    }
    write_pictures(view.output, pictures);
  }
  return rows;
}

void write_report(const PictureOptions& options, const gl::RenderScene& scene, const ReportFacts& facts,
                  const nlohmann::json& pictures) {
  const ShadingOptions& shading = options.shading;
  nlohmann::json report = {{"software", std::string("multum-view ") + MULTUM_VERSION},
                           {"context", facts.context.description()},
                           {"context_is_software", facts.context.is_software()},
                           {"width", options.output.width()},
                           {"height", options.output.height()},
                           {"reference_of", facts.comparison.is_of_texels() ? "texels" : "pixel"},
                           {"pixel_filter", choice_name(kPixelFilters, facts.comparison.sampling.filter)},
                           {"reference", "the BRDF times max(n.l, 0), with the normal of each sample"},
                           {"formula", choice_name(kLobeFormulas, shading.formula)},
                           {"moments", choice_name(kMomentShadings, shading.moments.value_or(kDefaultMomentShading))},
                           {"filter", filter_json(shading)},
                           {"pictures", pictures}};
  if (facts.brdf_is_in_map) report.update({{"brdf", "roughness-map"}});
  else report.update(brdf_json(scene.brdf));
  if (!options.light.environment.empty())
    report["environment_mode"] = choice_name(kEnvironmentModes, scene.environment_mode);
  write_text_file(options.output.report, json_text(report, 2) + "\n");
}

void write_shaders(const std::string& path, const std::vector<gl::ShaderVariant>& variants) {
  nlohmann::json rows = nlohmann::json::array();
  for (const gl::ShaderVariant& variant : variants)
    rows.push_back({{"flags", variant.flags}, {"fragment", variant.fragment}, {"uniforms", variant.uniforms}});
  write_text_file(path, json_text(rows, 2) + "\n");
}

}  // namespace multum
