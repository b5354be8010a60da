// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/tradeoff_page.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/foundation/base/base64.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/html/html_page.h"

namespace multum {
namespace {

std::string percent(double share) { return fmt::format("{:.2f}", 100.0 * share); }
std::string percent_if(double share) { return share < 0.0 ? "-" : percent(share); }
std::string millis(double seconds) { return fmt::format("{:.0f}", 1e3 * seconds); }
constexpr double kMiB = 1 << 20;
std::string frame_time(double ms) { return ms < 0.0 ? "-" : fmt::format("{:.1f}", ms); }
std::string mebi(std::uint64_t bytes) { return fmt::format("{:.2f}", static_cast<double>(bytes) / kMiB); }

// Formats the errors of a row, as in "12.3 +- 0.1 %, 14.1 % in its picture".
std::string errors_text(const TradeoffRow& row) {
  return error_text(row.reached.error, row.reached.confidence) +
         (row.rendered < 0.0 ? "" : fmt::format(", {} % in its picture", percent(row.rendered)));
}

// Formats the budgets that are set, as in "33 MiB on the GPU, 20 ms per frame".
std::string budgets_text(const TradeoffJob& job) {
  std::vector<std::string> parts;
  if (job.bytes_max) parts.push_back(fmt::format("{:.4g} MiB on the GPU", static_cast<double>(*job.bytes_max) / kMiB));
  if (job.frame_ms_max) parts.push_back(fmt::format("{:.4g} ms per frame", *job.frame_ms_max));
  if (job.bake_seconds_max) parts.push_back(fmt::format("{:.4g} ms of baking", 1e3 * *job.bake_seconds_max));
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::ptrdiff_t fitting_count(const TradeoffResult& result) {
  return std::count_if(result.rows.begin(), result.rows.end(),
                       [](const TradeoffRow& row) { return row.is_measured && row.fits; });
}

bool is_asked(const TradeoffJob& job) { return job.error || job.bake_seconds || job.has_budget(); }

std::string map_name(const TradeoffJob& job) { return std::filesystem::path(job.bake.input).filename().string(); }

// Quotes a text if a shell would not read it as a single word.
std::string shell_word(const std::string& text) {
  const bool is_plain = !text.empty() && text.find_first_not_of(
                                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                             "0123456789_./-+:=,@") == std::string::npos;
  if (is_plain) return text;
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string bake_command(const TradeoffJob& job, const TradeoffRow& row) {
  const std::string name = map_name(job), stem = std::filesystem::path(name).stem().string();
  std::string command =
      fmt::format("multum bake {} {} -o {}", shell_word(name), row.options, shell_word(stem + ".ndf.exr"));
  if (job.has_roughness())
    command += std::string(job.bake.roughness_is_gloss ? " --gloss " : " --roughness ") +
               shell_word(std::filesystem::path(job.bake.roughness).filename().string());
  // Adds the options for reading the map, if given.
  if (job.bake.reading.green) command += *job.bake.reading.green == GreenAxis::kUp ? " --green up" : " --green down";
  if (!row.view.empty())
    command += fmt::format("\nmultum-view {} {} -o picture.png", shell_word(stem + ".ndf.exr"), row.view);
  return command;
}

nlohmann::ordered_json row_json(const TradeoffJob& job, const TradeoffRow& row) {
  nlohmann::ordered_json one = {{"group", row.group},
                                {"bake", row.options},
                                {"view", row.view},
                                {"command", text_of_path(bake_command(job, row))},
                                {"bake_work_seconds", row.bake.work_seconds()},
                                {"bake_processor_seconds", row.bake.processor_seconds},
                                {"bake_device_seconds", row.bake.device_seconds},
                                {"bake_seconds", row.bake.elapsed_seconds},
                                {"file_bytes", row.file_bytes},
                                {"gpu_bytes", row.gpu_bytes}};
  if (row.normals_bytes > 0) one["normal_map_bytes"] = row.normals_bytes;
  if (row.normals_file_bytes > 0) one["normal_map_file_bytes"] = row.normals_file_bytes;
  if (job.has_budget()) one["fits"] = row.fits;
  if (!row.warnings.empty()) one["warnings"] = row.warnings;
  if (row.has_error)
    one.update({{"relative_l1", row.reached.error},
                {"confidence_95", row.reached.confidence},
                {"percentile_95", row.reached.percentile_95},
                {"worst_octave", row.reached.worst_octave},
                {"worst_octave_relative_l1", row.reached.worst_octave_error}});
  if (row.is_measured)
    one.update(
        {{"fronts",
          {{"bake_work", row.on_time_front}, {"gpu_bytes", row.on_size_front}, {"frame_work", row.on_frame_front}}}});
  if (row.same_as) one["same_as"] = *row.same_as;
  if (row.rendered >= 0.0)
    one.update(
        {{"rendered_relative_l1", row.rendered}, {"frame_work_ms", row.frame_work_ms}, {"frame_ms", row.frame_ms}});
  return one;
}

// Returns all results except the pictures.
nlohmann::ordered_json sweep_json(const TradeoffJob& job, const TradeoffResult& result) {
  nlohmann::ordered_json json = {{"software", std::string("multum ") + MULTUM_VERSION},
                                 {"map", text_of_path(map_name(job))},
                                 {"width", result.width},
                                 {"height", result.height},
                                 {"brdf", job.brdf.id.text()},
                                 {"device", result.device},
                                 {"renderer", result.renderer},
                                 {"bake_work_confidence_95", result.noise.bake},
                                 {"frame_work_confidence_95", result.noise.frame},
                                 {"seconds", result.seconds}};
  if (result.chosen) json["chosen"] = *result.chosen;
  if (job.bytes_max) json["budget"]["gpu_bytes"] = *job.bytes_max;
  if (job.frame_ms_max) json["budget"]["frame_ms"] = *job.frame_ms_max;
  if (job.bake_seconds_max) json["budget"]["bake_seconds"] = *job.bake_seconds_max;
  json["rows"] = nlohmann::ordered_json::array();
  for (const TradeoffRow& row : result.rows) json["rows"].push_back(row_json(job, row));
  return json;
}

// True if the page shows the row's picture.
bool is_shown(const TradeoffRow& row) {
  return !row.picture.empty() &&
         ((row.on_front() && !row.same_as) || row.group == "moments" || row.group == "hierarchy");
}

}  // namespace

std::string tradeoff_page(const TradeoffJob& job, const TradeoffResult& result) {
  nlohmann::ordered_json json = sweep_json(job, result);
  json["title"] = "What accuracy costs: " + text_of_path(map_name(job));
  json["setting_count"] = result.setting_count();
  json["fitting_count"] = fitting_count(result);
  json["asked"] = nlohmann::ordered_json::object();
  if (job.error) json["asked"]["error"] = *job.error;
  if (job.bake_seconds) json["asked"]["bake_seconds"] = *job.bake_seconds;
  json["view"] = {{"width", job.width}, {"height", job.height}, {"samples", job.samples}};
  json["has_others"] = !job.viewer.empty() && std::any_of(result.rows.begin(), result.rows.end(),
                                                          [](const TradeoffRow& row) { return !row.is_measured; });
  if (!result.reference.empty()) {
    json["reference_picture"] = encode_base64(result.reference);
    for (std::size_t i = 0; i < result.rows.size(); ++i)
      if (is_shown(result.rows[i])) json["rows"][i]["picture"] = encode_base64(result.rows[i].picture);
  }
  const auto& files = tradeoff_templates();
  return html_page({files.at("tradeoff.html"), files.at("tradeoff.css"), files.at("tradeoff.js")}, json);
}

std::string tradeoff_json(const TradeoffJob& job, const TradeoffResult& result) {
  return json_text(sweep_json(job, result), 2) + "\n";
}

std::string tradeoff_markdown(const TradeoffResult& result) {
  std::string text =
      "| settings | drawn with | error | 95 % | 95th percentile | worst octave | rendered | bake, ms of work | "
      "elapsed, ms | frame, ms of work | elapsed, ms | GPU, MiB |\n"
      "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const TradeoffRow& row : result.rows) {
    const auto if_known = [&](double share) { return row.has_error ? percent(share) : std::string("-"); };
    text += fmt::format("| `{}` | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", row.options,
                        row.view.empty() ? "" : "`" + row.view + "`", if_known(row.reached.error),
                        if_known(row.reached.confidence), if_known(row.reached.percentile_95),
                        if_known(row.reached.worst_octave_error), percent_if(row.rendered),
                        millis(row.bake.work_seconds()), millis(row.bake.elapsed_seconds),
                        frame_time(row.frame_work_ms), frame_time(row.frame_ms), mebi(row.gpu_bytes));
  }
  return text;
}

std::string tradeoff_text(const TradeoffJob& job, const TradeoffResult& result) {
  std::string text =
      "settings for which no other settings have both a lower error and a lower cost (work of a bake, memory, or work "
      "of a frame):\n";
  for (const TradeoffRow& row : result.rows) {
    if (!row.on_front() || row.same_as || !row.fits) continue;
    text += fmt::format("  {:>16}  {:>6} ms  {:>8} MiB  {}  {} {}\n", errors_text(row), millis(row.bake.work_seconds()),
                        mebi(row.gpu_bytes),
                        row.frame_ms < 0.0 ? "" : fmt::format("{:6.1f} ms per frame", row.frame_work_ms), row.options,
                        row.view);
    const auto number = static_cast<std::size_t>(&row - result.rows.data());
    for (const TradeoffRow& other : result.rows)
      if (other.same_as == number)
        text += fmt::format("  {:>16}  indistinguishable: {} {}\n", "", other.options, other.view);
  }
  if (job.has_budget())
    text +=
        fmt::format("within {}: {} of {} settings\n", budgets_text(job), fitting_count(result), result.setting_count());
  if (!is_asked(job)) return text;
  if (!result.chosen) return text + "no settings meet this\n";
  const TradeoffRow& chosen = result.rows[*result.chosen];
  text += fmt::format(
      "chosen: {}; 95 % of pixels have errors of at most {} %; the worst pixels cover {} and have an error of {} %\n",
      chosen.options, percent(chosen.reached.percentile_95), octave_text(chosen.reached.worst_octave),
      percent(chosen.reached.worst_octave_error));
  return text;
}

}  // namespace multum
