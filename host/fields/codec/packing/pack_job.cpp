// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packing/pack_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/fields/inferred/inference_error.h"
#include "host/foundation/base/choices.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using OrderedJson = nlohmann::ordered_json;

}  // namespace

void apply(const ParameterValues& values, FieldPackSettings& settings) {
  settings.alpha = values.number("alpha").value_or(settings.alpha);
  if (settings.alpha != 0.0 && settings.alpha <= 1.0)
    throw Error(ErrorCode::kUsage, fmt::format("--alpha is {:g}, expected a number above 1, or 0", settings.alpha));
  settings.pyramid = values.choice("pyramid", kPyramidChoices).value_or(settings.pyramid);
  const std::string coder = values.text("coder").value_or("auto");
  if (coder != "auto") settings.coder = coder == "dct" ? ImageCoder::kDct : ImageCoder::kWavelet;
  settings.open_loop = values.text("loop") == "open";
  settings.target.ratio = values.number("ratio");
  if (const auto bytes = values.bytes("bytes")) settings.target.bytes = static_cast<double>(*bytes);
  settings.target.mse = values.number("mse_max");
  settings.target.lambda = values.number("lambda");
  settings.block = values.integer("block").value_or(settings.block);
  settings.stagger = values.text("stagger") == "yes";
  if (const auto bytes = values.bytes("memory")) settings.memory_bytes = static_cast<std::uint64_t>(*bytes);
  settings.resume = values.flag("resume");
  settings.has_absolute_geometry = values.flag("absolute_geometry");
}

std::string field_folder(const std::string& named) {
  const std::filesystem::path path(named);
  if (path.filename() != kInferredManifestName || std::filesystem::is_directory(path)) return named;
  return path.has_parent_path() ? path.parent_path().string() : ".";
}

void warn_of_pack_errors(const FieldPackSettings& settings, const FieldPackReport& report) {
  if (!report.is_alpha_met)
    log_warning(
        settings.output,
        fmt::format("the error of an object exceeds --alpha {:g} times the mean error; --verbose lists the objects",
                    settings.alpha));
  if (!report.inferred_mse && settings.target.is_default())
    log_warning(settings.output,
                fmt::format("{}/{} does not state the error of the inferred textures, so packing at {:g}:1 added an "
                            "MSE of about {:.3g}, which could not be checked. Run multum infer again, or choose a size "
                            "or an error with --ratio, --bytes or --mse-max",
                            settings.folder, kInferenceReportName, kDefaultRatio, report.mse));
  if (report.is_error_large)
    log_warning(
        settings.output,
        fmt::format("packing adds an MSE of about {:.3g}, which is {:.3g} times the error of the inferred "
                    "textures ({:.3g}). {}",
                    report.mse, report.mse / std::max(*report.inferred_mse, 1e-9), *report.inferred_mse,
                    settings.target.is_default() ? "No smaller error was found, although the factor should stay below 3"
                                                 : "Without --ratio, --bytes and --lambda, the factor stays below 3"));
}

std::string pack_report_json(const FieldPackSettings& settings, const FieldPackReport& report) {
  OrderedJson json = {{"output", text_of_path(settings.output)},
                      {"bytes", report.bytes},
                      {"raw_bytes", report.raw_bytes},
                      {"description_bytes", report.description_bytes},
                      {"mse_added", report.mse},
                      {"lambda", report.lambda},
                      {"rounds", report.rounds},
                      {"chunks_resumed", report.chunks_resumed},
                      {"is_alpha_met", report.is_alpha_met},
                      {"is_error_large", report.is_error_large},
                      {"objects", OrderedJson::array()},
                      {"chunks", OrderedJson::array()}};
  if (report.inferred_mse) json["inferred_mse"] = *report.inferred_mse;
  for (const PackedObjectReport& object : report.objects)
    json["objects"].push_back({{"object", object.object}, {"mse", object.mse}, {"lambda", object.lambda}});
  for (const PackedChunkReport& chunk : report.chunks)
    json["chunks"].push_back({{"object", chunk.object},
                              {"layer", chunk.layer},
                              {"block", chunk.block},
                              {"bytes", chunk.bytes},
                              {"mse", chunk.mse}});
  return json_text(json);
}

}  // namespace multum
