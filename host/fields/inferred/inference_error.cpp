// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inferred/inference_error.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

/// Returns the mean error of an entry times its pixel count. `mse` is null if there are no pixels.
double error_sum(const nlohmann::json& entry) {
  const double pixels = entry.at("pixels").get<double>();
  return pixels > 0.0 ? entry.at("mse").get<double>() * pixels : 0.0;
}

double sum_of_layers(const nlohmann::json& report) {
  double sum = 0.0;
  for (const nlohmann::json& texture : report.at("textures"))
    for (const nlohmann::json& sample : texture.at("samples")) sum += error_sum(sample);
  return sum;
}

}  // namespace

std::optional<double> inference_error_sum(const std::string& folder) {
  try {
    const std::optional<std::string> text = json_of_file(folder + "/" + kInferenceReportName);
    if (!text) return {};
    const nlohmann::json report = nlohmann::json::parse(*text);
    const nlohmann::json& frames = report.at("frames");
    const double sum = frames.is_null() ? sum_of_layers(report) : error_sum(frames);
    if (std::isfinite(sum) && sum >= 0.0) return sum;
  } catch (const Error&) {                      // there is no such file
  } catch (const nlohmann::json::exception&) {  // not a report of `multum infer`
  }
  return {};
}

}  // namespace multum
