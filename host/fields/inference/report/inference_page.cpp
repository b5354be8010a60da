// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_page.h"

#include <nlohmann/json.hpp>

#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/html/html_page.h"

namespace multum {
namespace {

using PageJson = nlohmann::ordered_json;

PageJson picture_json(const ReportPicture& one) {
  return {{"file", one.file}, {"width", one.width}, {"height", one.height}};
}

PageJson three_json(const PictureRow& row) {
  return {{"ray_traced", picture_json(row.ray_traced)},
          {"rendered", picture_json(row.rendered)},
          {"error", picture_json(row.error)},
          {"mse", row.squared_error}};
}

PageJson pictures_json(const ReportPictures& pictures) {
  PageJson json = {{"frame", nullptr}, {"objects", PageJson::array()}, {"textures", PageJson::array()}};
  if (pictures.has_frame) {
    json["frame"] = three_json(pictures.frame);
    for (const PictureRow& row : pictures.objects)
      json["objects"].push_back(row.error.width > 0 ? three_json(row) : PageJson(nullptr));
  }
  for (const ReportPictures::Texture& one : pictures.textures)
    json["textures"].push_back({{"object", one.object}, {"layer", one.layer}, {"picture", picture_json(one.picture)}});
  return json;
}

}  // namespace

std::string inference_page(const InferenceReport& report, const ReportPictures& pictures) {
  PageJson json = inference_figures(report);
  json["title"] = "Inferred textures of " + json["job"].get<std::string>();
  json["samples"] = PageJson::array();
  for (const AnimationSample& sample : report.job.samples)
    json["samples"].push_back({{"name", sample.name}, {"at", sample.at}});
  json["layers"] = PageJson::array();
  for (const AnimationLayer& layer : report.job.layers) json["layers"].push_back(layer.name);
  std::size_t object = 0, of_object = 0;
  for (const LayerSummary& one : summarise_layers(report)) {
    of_object = one.object == object ? of_object : 0;
    object = one.object;
    json["objects"][object]["layers"][of_object++]["texels"] = texel_count_text(report, one, " \u00d7 ");
  }
  if (report.frames != nullptr)
    for (std::size_t i = 0; i < report.frames->frames.size(); ++i)
      json["frames"]["samples"][i]["sample"] = report.frames->frames[i].sample;
  json["pictures"] = pictures_json(pictures);
  const auto& files = inference_templates();
  return html_page({files.at("inference.html"), "", files.at("inference.js")}, json);
}

void write_inference_report(const ParameterizedScene& field, const InferenceReport& report) {
  const std::string& folder = report.settings.output;
  write_text_file(folder + "/report.json", inference_report_json(report));
  const ReportPictures pictures = write_report_pictures(field, report);
  write_text_file(folder + "/report.html", inference_page(report, pictures));
}

}  // namespace multum
