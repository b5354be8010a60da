// SPDX-License-Identifier: Apache-2.0
// Writes the text of a result of `multum-bench filters`. The tables list medians over the maps, for every filter and
// method.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "host/formats/asset/tap_filter.h"
#include "runtime_gl/render/scene.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/documents/result_view.h"
#include "tools/lab/bench/filter_benchmark.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kTimedBias = -0.5;  // frame times hardly depend on the bias

struct FilterKey {
  int taps;
  double bias;
  bool shades_taps;
  int evaluations = 0;  // evaluations of light per pixel; 0 if the number of taps determines it

  auto operator<=>(const FilterKey&) const = default;
};

FilterKey key_of(const Json& row) {
  return {row.at("taps").get<int>(), row.at("bias").get<double>(), row.at("shades_taps").get<bool>(),
          row.value("evaluations", 0)};
}

// Contains one figure per map, for each filter and method.
using Figures = std::map<FilterKey, std::map<std::string, std::vector<double>>>;

Figures figures_of(const Json& result, const char* list, const std::function<double(const Json&)>& value) {
  Figures figures;
  for (const Json& map : result.at("maps"))
    for (const Json& row : map.value(list, Json::array()))
      figures[key_of(row)][row.at("method").get<std::string>()].push_back(value(row));
  return figures;
}

Figures figures_of(const Json& result, const char* list, const char* field) {
  return figures_of(result, list, [field](const Json& row) { return row.at(field).get<double>(); });
}

// Keeps either the filters with a fixed number of evaluations or the filters without one.
Figures with_budget(Figures figures, bool has_budget) {
  std::erase_if(figures, [&](const auto& entry) { return (entry.first.evaluations > 0) != has_budget; });
  return figures;
}

// Returns the methods in the order in which they were measured.
std::vector<std::string> methods_of(const Json& result, const char* list) {
  std::vector<std::string> methods;
  for (const Json& row : result.at("maps").at(0).at(list))
    if (const auto name = row.at("method").get<std::string>();
        std::find(methods.begin(), methods.end(), name) == methods.end())
      methods.push_back(name);
  return methods;
}

double median_of(const Figures& figures, const FilterKey& key, const std::string& method) {
  return spread_of(figures.at(key).at(method)).median;
}

std::vector<std::string> head_of(std::vector<std::string> first, const std::vector<std::string>& methods) {
  first.insert(first.end(), methods.begin(), methods.end());
  return first;
}

std::string percent_text(double value) { return fmt::format("{:.1f}", 100.0 * value); }

// Sorts filters by their number of taps, and then from the plain level to the sharpest level. Filters that shade each
// tap come last.
std::vector<FilterKey> keys_of(const Figures& figures) {
  std::vector<FilterKey> keys;
  for (const auto& [key, unused] : figures) keys.push_back(key);
  std::sort(keys.begin(), keys.end(), [](const FilterKey& a, const FilterKey& b) {
    return std::tuple(a.evaluations, a.shades_taps, a.taps, -a.bias) <
           std::tuple(b.evaluations, b.shades_taps, b.taps, -b.bias);
  });
  return keys;
}

const char* taps_head(const Figures& figures) {
  return !figures.empty() && figures.begin()->first.evaluations > 0 ? "evaluations" : "taps";
}

std::string taps_text(const FilterKey& key) {
  if (key.evaluations > 0) return fmt::format("{}", key.evaluations);
  return fmt::format("{}{}", key.taps, key.shades_taps ? ", each shaded" : "");
}

std::string table_of(const Figures& figures, const std::vector<std::string>& methods,
                     const std::function<std::string(double)>& text) {
  MarkdownTable table(head_of({taps_head(figures), "bias"}, methods));
  for (const FilterKey& key : keys_of(figures)) {
    std::vector<std::string> row = {taps_text(key), fmt::format("{:g}", key.bias)};
    for (const std::string& method : methods) row.push_back(text(median_of(figures, key, method)));
    table.add(row);
  }
  return table.text();
}

// Makes a table of the errors of each method at its best bias.
std::string best_bias_table(const Figures& figures, const std::vector<std::string>& methods) {
  MarkdownTable table(head_of({taps_head(figures)}, methods));
  std::vector<FilterKey> keys = keys_of(figures);
  for (auto first = keys.begin(); first != keys.end();) {
    const auto last = std::find_if(first, keys.end(), [&](const FilterKey& key) {
      return key.taps != first->taps || key.shades_taps != first->shades_taps || key.evaluations != first->evaluations;
    });
    std::vector<std::string> row = {taps_text(*first)};
    for (const std::string& method : methods) {
      const auto best = std::min_element(first, last, [&](const FilterKey& a, const FilterKey& b) {
        return median_of(figures, a, method) < median_of(figures, b, method);
      });
      row.push_back(fmt::format("{} at {:g}", percent_text(median_of(figures, *best, method)), best->bias));
    }
    table.add(row);
    first = last;
  }
  return table.text();
}

// Makes a table of the flicker of four lobes, for each motion.
std::string motion_table(const Json& result) {
  Figures figures;
  std::vector<std::string> motions;
  for (const Json& map : result.at("maps"))
    for (const Json& row : map.value("motions", Json::array())) {
      if (row.at("method").get<std::string>() != "4 lobes" || key_of(row).evaluations > 0) continue;
      const auto motion = row.at("motion").get<std::string>();
      if (std::find(motions.begin(), motions.end(), motion) == motions.end()) motions.push_back(motion);
      figures[key_of(row)][motion].push_back(row.at("flicker").get<double>());
    }
  return table_of(figures, motions, percent_text);
}

// Returns frame times, divided by the time of the same method with one tap at level bias 0 in the same run.
Figures time_ratios(const Json& result) {
  Figures figures;
  for (const Json& map : result.at("maps")) {
    std::map<std::string, double> plain;
    for (const Json& row : map.at("pictures"))
      if (key_of(row) == FilterKey{1, 0.0, false} && !row.at("frame_processor_ms").is_null())
        plain[row.at("method").get<std::string>()] = row.at("frame_processor_ms");
    for (const Json& row : map.at("pictures"))
      if (key_of(row).bias == kTimedBias && !row.at("frame_processor_ms").is_null()) {
        const auto method = row.at("method").get<std::string>();
        figures[key_of(row)][method].push_back(row.at("frame_processor_ms").get<double>() / plain.at(method));
      }
  }
  return figures;
}

std::string worst_noise(const Json& result, const char* field) {
  double worst = 0.0;
  for (const Json& map : result.at("maps")) worst = std::max(worst, map.at(field).get<double>());
  return fmt::format("{:.2f} %", 100.0 * worst);
}

std::string map_names(const Json& result) {
  std::string names;
  for (const Json& map : result.at("maps")) names += (names.empty() ? "" : ", ") + map.at("map").get<std::string>();
  return names;
}

std::string sample_range(const Json& result) {
  int low = 1 << 30, high = 0;
  for (const Json& map : result.at("maps")) {
    low = std::min(low, map.at("samples").get<int>());
    high = std::max(high, map.at("samples").get<int>());
  }
  return fmt::format("{} to {}", low, high);
}

// For four lobes, compares the default filter with a filter that has half as many taps and shades them separately. Both
// filters take about the same time.
std::string default_text(const Json& result, const Figures& errors) {
  const Figures flicker = figures_of(result, "motions", "flicker"), times = time_ratios(result);
  const auto describe = [&](int taps, bool shades_taps) {
    const std::string method = "4 lobes";
    const FilterKey key{taps, kLevelBiasDefault, shades_taps}, timed{taps, kTimedBias, shades_taps};
    return fmt::format(
        "the error is {} %, the flicker is {} %, and the processor time is {:.2f} times the time of one tap",
        percent_text(median_of(errors, key, method)), percent_text(median_of(flicker, key, method)),
        median_of(times, timed, method));
  };
  return fmt::format(
      "The **default** is {} taps at a bias of {:g}, which are averaged and shaded once, as with an anisotropic "
      "sampler. With 4 "
      "lobes, {}. If two taps at the same bias are shaded separately, {}.\n\n",
      kTapCountDefault, kLevelBiasDefault, describe(kTapCountDefault, kShadesTapsDefault), describe(2, true));
}

// Compares all methods with an equal number of evaluations. There is one evaluation per lobe, or one per point.
std::string evaluations_text(const Json& result, const std::vector<std::string>& methods,
                             const std::vector<std::string>& moving) {
  const Figures errors = with_budget(figures_of(result, "pictures", "error"), true);
  if (errors.empty()) return "";
  std::string text = fmt::format(
      "The next tables compare methods **with an equal number of evaluations** of light per pixel. Each evaluation "
      "uses {} taps (`multum-view "
      "--evaluations`). For lobes, multum's rule divides the evaluations between lobes and points. Other methods are "
      "shaded at as many points per pixel as there are evaluations. The table lists the errors in % of each method at "
      "its best bias:\n\n",
      kTapCountDefault);
  text += best_bias_table(errors, methods);
  text += "\nThe next table lists the flicker in %, with an equal number of evaluations:\n\n";
  text += table_of(with_budget(figures_of(result, "motions", "flicker"), true), moving, percent_text);
  text +=
      "\nThe next table lists the processor time per frame with an equal number of evaluations, divided by the time of "
      "the same method with one tap at bias 0:\n\n";
  text += table_of(with_budget(time_ratios(result), true), methods,
                   [](double ratio) { return fmt::format("{:.2f}", ratio); });
  return text + "\n";
}

}  // namespace

ResultView view_filters(const Json& result) {
  const std::vector<std::string> methods = methods_of(result, "pictures"), moving = methods_of(result, "motions");
  const Figures errors = with_budget(figures_of(result, "pictures", "error"), false);
  const Figures flicker = with_budget(figures_of(result, "motions", "flicker"), false);
  std::string tables = default_text(result, errors) + evaluations_text(result, methods, moving) +
                       "The next table lists picture errors (relative L1 errors in %) as medians over the maps:\n\n";
  tables += table_of(errors, methods, percent_text);
  tables += "\nThe next table lists, for each method, the lowest error in % and the bias that gives this error:\n\n";
  tables += best_bias_table(errors, methods);
  tables +=
      "\nThe next table lists the flicker in %, averaged over a zoom, a pan and a turn. The values are medians over "
      "every fourth map:\n\n";
  tables += table_of(flicker, moving, percent_text);
  tables += "\nThe next table lists the flicker of 4 lobes in %, for each motion:\n\n" + motion_table(result);
  tables +=
      "\nThe next table lists the processor time per frame, divided by the time of the same method with one tap at "
      "bias 0. The values are medians over the maps, for GL in software at bias -0.5:\n\n";
  tables += table_of(with_budget(time_ratios(result), false), methods,
                     [](double ratio) { return fmt::format("{:.2f}", ratio); });
  tables +=
      "\nThe next table lists errors in % against a reference that blends the light of the four finest texels around a "
      "point. With this reference, blur by magnification does not count as an error of the bake:\n\n";
  tables += table_of(with_budget(figures_of(result, "pictures", "error_blended"), false), methods, percent_text);
  return {
      "Texture filters",
      fmt::format(
          "The scene is the same oblique plane as in `tools/lab/reproduce maps`, drawn at {} x {} pixels with "
          "Blinn-Phong (s = "
          "100). "
          "The {} maps are {}. Flicker is measured on pictures with half of this width and height. Every method uses "
          "the "
          "same filter (`multum-view --taps --level-bias`). The reference averages {} samples of the finest "
          "level per pixel with a box filter. The noise of the reference is at most {}. The noise of the blended "
          "reference is at most {}. *Flicker* is `sum |(f' - f) - (t' - t)| / sum t` for neighbouring frames `f`, `f'` "
          "and their references `t`, `t'`. LEAN is drawn with its Jacobian.",
          result.at("width").get<int>(), result.at("height").get<int>(), result.at("maps").size(), map_names(result),
          sample_range(result), worst_noise(result, "noise"), worst_noise(result, "noise_blended")),
      tables};
}

}  // namespace multum::bench
