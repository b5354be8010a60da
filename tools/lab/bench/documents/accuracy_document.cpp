// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/accuracy_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>

#include "host/bakes/accuracy/accuracy_baselines.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/bakes/settings_search/tradeoff_page.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/testmap/four_quarter_map.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/run_times.h"
#include "tools/lab/bench/documents/committed_tree.h"
#include "tools/lab/bench/documents/formula_document.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/measuring/scratch_folder.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

constexpr AccuracyPoint kPoints[] = {AccuracyPoint::kCentre, AccuracyPoint::kMidX, AccuracyPoint::kMidY,
                                     AccuracyPoint::kBetween};

// Errors of a bake in %, looked up by level, point and BRDF.
class Errors {
 public:
  explicit Errors(const std::vector<AccuracyRow>& rows) {
    for (const AccuracyRow& row : rows)
      values_[{row.level, static_cast<int>(row.point), row.brdf.text()}] = row.error * 100.0;
  }
  std::optional<double> at(int level, AccuracyPoint point, const std::string& brdf) const {
    const auto found = values_.find({level, static_cast<int>(point), brdf});
    return found == values_.end() ? std::nullopt : std::optional<double>(found->second);
  }
  std::string text(int level, AccuracyPoint point, const std::string& brdf) const {
    const auto value = at(level, point, brdf);
    return value ? fmt::format("{:.2f}", *value) : "-";
  }
  // Returns the error midway between texels in x or the error midway in y, whichever is higher.
  std::string midway(int level, const std::string& brdf) const {
    const auto x = at(level, AccuracyPoint::kMidX, brdf), y = at(level, AccuracyPoint::kMidY, brdf);
    return text(level, x.value_or(0.0) >= y.value_or(0.0) ? AccuracyPoint::kMidX : AccuracyPoint::kMidY, brdf);
  }
  // Returns the errors of levels 3, 5 and 7, such as "10.3 / 6.8 / 6.6".
  std::string three_levels(AccuracyPoint point, const std::string& brdf) const {
    std::string text;
    for (int level : {3, 5, 7}) {
      const auto value = at(level, point, brdf);
      text += (text.empty() ? "" : " / ") + (value ? fmt::format("{:.1f}", *value) : std::string("-"));
    }
    return text;
  }

 private:
  std::map<std::tuple<int, int, std::string>, double> values_;
};

struct Variant {
  std::string name;
  MovmfSettings settings;
  StorageEncoding encoding = StorageEncoding::kSnorm16;
};

MovmfMipmap bake_stored(Device& device, const NormalMap& map, const ColourMap* albedo, const Variant& variant,
                        int threads, FitReport& report) {
  MovmfMipmap mipmap = bake_movmf(device, map, albedo, variant.settings, report, nullptr);
  mipmap.header.encoding = variant.encoding;
  quantize_movmf(mipmap, threads);
  return mipmap;
}

AccuracySettings every_texel(int threads) {
  AccuracySettings accuracy;
  accuracy.samples_per_level = 0;
  accuracy.footprints_per_octave = 0;
  accuracy.threads = threads;
  return accuracy;
}

Errors measure(Device& device, const NormalMap& map, const ColourMap* albedo, const Variant& variant, int threads) {
  FitReport report;
  const MovmfMipmap mipmap = bake_stored(device, map, albedo, variant, threads, report);
  return Errors(measure_accuracy(device, mipmap, map, albedo, every_texel(threads), nullptr));
}

// Measures the times of fits of all variants, after their kernels were compiled.
std::vector<RunTime> fit_times(Device& device, const NormalMap& map, const std::vector<Variant>& variants) {
  std::printf("times, %d rounds\n", kTimedRounds);
  std::vector<std::function<void()>> runs;
  for (const Variant& variant : variants)
    runs.push_back([&device, &map, &variant] {
      FitReport report;
      bake_movmf(device, map, nullptr, variant.settings, report, nullptr);
    });
  return time_in_turns(runs, kTimedRounds, nullptr);
}

MovmfSettings with_lobes(int lobes) {
  MovmfSettings settings;
  settings.lobe_count = lobes;
  settings.periodic_x = settings.periodic_y = true;  // as by default in `multum bake`
  return settings;
}

std::string level_table(const Errors& errors, int level_count) {
  std::string text =
      "| level | s = 100, centres | midway in x | midway in y | between l and l+1 | s = 20 | s = 500 | Lambert |\n"
      "|---|---|---|---|---|---|---|---|\n";
  for (int level = 0; level < level_count; ++level) {
    text += fmt::format("| {} |", level);
    for (AccuracyPoint point : kPoints) text += " " + errors.text(level, point, "blinn-phong:100") + " |";
    for (const char* brdf : {"blinn-phong:20", "blinn-phong:500", "lambert"})
      text += " " + errors.text(level, AccuracyPoint::kCentre, brdf) + " |";
    text += "\n";
  }
  return text;
}

// Returns one line of the summary, with the errors of levels 3 / 5 / 7.
std::string summary_line(const std::string& name, const Errors& errors) {
  std::string text = "| " + name + " |";
  for (AccuracyPoint point : kPoints) text += " " + errors.three_levels(point, "blinn-phong:100") + " |";
  for (const char* brdf : {"blinn-phong:20", "blinn-phong:500", "lambert"})
    text += " " + errors.three_levels(AccuracyPoint::kCentre, brdf) + " |";
  return text;
}

constexpr char kSummaryHead[] =
    "| | s = 100, centres | midway in x | midway in y | between l and l+1 | s = 20 | s = 500 | Lambert |";
constexpr char kSummaryRule[] = "|---|---|---|---|---|---|---|---|";

std::vector<Variant> compared_variants() {
  std::vector<Variant> variants;
  for (int lobes : {1, 2, 3, 4, 6, 8})
    variants.push_back({fmt::format("{} lobe{}", lobes, lobes == 1 ? "" : "s"), with_lobes(lobes)});
  Variant unaligned{"4 lobes, unaligned", with_lobes(4)};
  make_unaligned(unaligned.settings);
  variants.push_back(unaligned);
  Variant no_prior{"4 lobes, started from the parent's lobes, without a prior", with_lobes(4)};
  no_prior.settings.alignment = 0.0f;
  variants.push_back(no_prior);
  Variant one_pass{"4 lobes, one pass", with_lobes(4)};
  one_pass.settings.pass_count = 1;
  variants.push_back(one_pass);
  Variant unsearched{"4 lobes, without a search for the starting lobes", with_lobes(4)};
  unsearched.settings.search_start = false;
  variants.push_back(unsearched);
  Variant farthest{"4 lobes, started from the farthest normals (as in the paper)", with_lobes(4)};
  farthest.settings.farthest_start = true;
  variants.push_back(farthest);
  Variant scanline{"4 lobes, scan-line order (as in the paper)", with_lobes(4)};
  scanline.settings.order = FitOrder::kScanline;
  variants.push_back(scanline);
  for (const int lobes : {4, 6}) {
    Variant reference{fmt::format("{} lobes, --reference", lobes), with_lobes(lobes)};
    make_reference(reference.settings);
    variants.push_back(reference);
  }
  Variant half{"4 lobes, stored as 16-bit floats", with_lobes(4), StorageEncoding::kHalf};
  variants.push_back(half);
  Variant whole{"4 lobes, stored as 32-bit floats", with_lobes(4), StorageEncoding::kFloat};
  variants.push_back(whole);
  return variants;
}

std::string quarters_section(Device& device, const AccuracyDocumentOptions& options) {
  const FourQuarterMap map = make_four_quarter_map(options.size, 7);
  const int levels = mip_level_count(options.size, options.size);
  std::string summary = fmt::format("{} fit, processor s | elapsed, s |\n{}---|---|\n", kSummaryHead, kSummaryRule);
  std::string tables;
  const std::vector<Variant> variants = compared_variants();
  std::vector<std::string> lines;
  for (const Variant& variant : variants) {
    std::printf("four-quarter map, %s\n", variant.name.c_str());
    const Errors errors = measure(device, map.normals, nullptr, variant, options.threads);
    lines.push_back(summary_line(variant.name, errors));
    if (variant.name == "4 lobes" || variant.name == "6 lobes")
      tables += fmt::format("\n### All levels, {}\n\n", variant.name) + level_table(errors, levels);
  }
  const std::vector<RunTime> times = fit_times(device, map.normals, variants);
  for (std::size_t i = 0; i < variants.size(); ++i)
    summary += fmt::format("{} {:.2f} | {:.2f} |\n", lines[i], times[i].processor_seconds, times[i].elapsed_seconds);
  std::string seeds = fmt::format("{}\n{}\n", kSummaryHead, kSummaryRule);
  for (std::uint64_t seed : {1, 2, 3})
    for (int lobes : {4, 6}) {
      const FourQuarterMap other = make_four_quarter_map(options.size, seed);
      const Variant variant{fmt::format("seed {}, {} lobes", seed, lobes), with_lobes(lobes)};
      seeds += summary_line(variant.name, measure(device, other.normals, nullptr, variant, options.threads)) + "\n";
    }
  std::string colours = "| | s = 20 | s = 100 | s = 500 | Lambert |\n|---|---|---|---|---|\n";
  for (int lobes : {4, 6}) {
    const Errors errors = measure(device, map.normals, &map.albedo, {"", with_lobes(lobes)}, options.threads);
    colours += fmt::format("| {} lobes |", lobes);
    for (const char* brdf :
         {"blinn-phong:20 coloured", "blinn-phong:100 coloured", "blinn-phong:500 coloured", "lambert coloured"})
      colours += " " + errors.three_levels(AccuracyPoint::kCentre, brdf) + " |";
    colours += "\n";
  }
  return fmt::format(
             "The table lists the errors of levels 3, 5 and 7 over all texels of a white map. Each time is the "
             "shortest "
             "of {} fits on {} cores, and includes the time to compute the starting lobes. Before the timed fits, one "
             "fit per row "
             "compiled the kernels. The timed fits of the rows ran alternately. *Processor s* is processor time in "
             "seconds.\n\n",
             kTimedRounds, core_count()) +
         summary +
         fmt::format(
             "\nThe next table lists the errors for other random seeds of the noise quarter, to show how much "
             "the errors depend on chance. Level 7 has only {0} x {0} texels.\n\n",
             std::max(options.size >> 7, 1)) +
         seeds +
         "\nThe next table lists errors with lobe colours at texel centres of levels 3, 5 and 7. The reference uses "
         "the "
         "colour of each normal.\n\n" +
         colours + tables;
}

// Returns the size of the file, which is written next to the document and then removed.
std::uintmax_t file_bytes(const MovmfMipmap& mipmap, const AccuracyDocumentOptions& options) {
  const std::string path = options.output + ".first_level.ndf.exr";
  BakedWriteOptions writing;
  writing.threads = options.threads;
  write_movmf_mipmap(path, mipmap, writing);
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  std::filesystem::remove(path);
  return bytes;
}

// Returns errors and sizes for bakes whose finest levels come from the normal map. The stored levels are the same in
// all rows.
std::string first_level_section(Device& device, const AccuracyDocumentOptions& options) {
  const FourQuarterMap map = make_four_quarter_map(options.size, 7);
  FitReport report;
  MovmfMipmap mipmap = bake_stored(device, map.normals, nullptr, {"", with_lobes(4)}, options.threads, report);
  const auto usual = static_cast<double>(default_gpu_bytes(options.size, options.size));
  std::string rows;
  for (const int first_level : {0, 1, 2}) {
    std::printf("four-quarter map, stored from level %d on\n", first_level);
    drop_finer_levels(mipmap, first_level);
    const Errors errors(measure_accuracy(device, mipmap, map.normals, every_texel(options.threads), nullptr));
    const auto gpu = static_cast<double>(movmf_gpu_bytes(mipmap));
    const std::string sizes =
        fmt::format(" {:.1f} | {:.1f} | {:.1f} |\n", static_cast<double>(file_bytes(mipmap, options)) / 1e6, gpu / 1e6,
                    gpu / usual);
    for (const char* s : {"20", "100", "500"}) {
      const std::string brdf = std::string("blinn-phong:") + s;
      rows += fmt::format("| {} | {} |", first_level, s);
      for (const int level : {0, 1}) {
        rows += " " + errors.text(level, AccuracyPoint::kCentre, brdf) + " | " + errors.midway(level, brdf) + " | " +
                errors.text(level, AccuracyPoint::kBetween, brdf) + " |";
      }
      rows += " " + errors.text(2, AccuracyPoint::kCentre, brdf) + " |" + sizes;
    }
  }
  return fmt::format(
             "\n### Finest levels from the normal map\n\nThe bakes have 4 lobes and store only level L and coarser "
             "levels (`multum bake --first-level L`). Each texel of a finer level has one lobe, which is the mean "
             "vector of the normal map's mip level. Between levels L - 1 and L, both levels are shaded, and the "
             "results are mixed. *Midway* lists the error midway between texels in x or the error midway in y, "
             "whichever is higher. All errors are errors of the mixed results. In addition, renderers narrow the "
             "normal map's lobe to the part that a pixel sees ([ALGORITHMS](../contributing/ALGORITHMS.md), \"The "
             "finest levels from the normal map\"). Sizes of the file and of the GPU textures are in MB. BC5 normals "
             "and BC4 roughness of this map take {:.1f} MB on the GPU.\n\n",
             usual / 1e6) +
         "| L | s | 0, centres | 0, midway | between 0 and 1 | 1, centres | 1, midway | between 1 and 2 | 2, centres | "
         "file, MB | GPU, MB | GPU size / (BC5 + BC4) |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n" +
         rows;
}

// Makes a table with "multum's error / error of the best baseline" for every level. multum's error is bold if it is
// more than 0.05 points higher.
struct MapTable {
  std::string rows;
  int cells = 0, worse = 0;
  std::string losses;
};

// Contains the errors of all maps at levels from 1 on, by method and exponent. Level 0 is omitted, because its texels
// are single normals, so methods that store single normals have no error there.
using MapErrors = std::map<std::pair<std::string, double>, std::vector<double>>;

// A row of the table that is sorted by number of channels. Methods with the same number of channels are next to each
// other.
struct Rival {
  const char* name;   // key of MapErrors
  const char* title;  // name in the table
  int channels;       // number of channels per texel
};
constexpr Rival kRivals[] = {{"mip", "averaged normals", 3},
                             {"Toksvig", "Toksvig", 3},
                             {"1 lobe", "1 lobe", 4},
                             {"LEAN", "LEAN", 5},
                             {"LEAN with Jacobian", "LEAN with its Jacobian", 5},
                             {"2 lobes", "2 lobes", 8},
                             {"4 lobes", "4 lobes", 16},
                             {"6 lobes", "6 lobes", 24}};

std::string equal_channels_table(const MapErrors& errors) {
  MarkdownTable table({"texels hold", "channels per texel", "s = 20", "s = 100", "s = 500"});
  for (const Rival& rival : kRivals) {
    std::vector<std::string> cells = {rival.title, std::to_string(rival.channels)};
    for (const double s : {20.0, 100.0, 500.0}) {
      const auto found = errors.find({rival.name, s});
      if (found == errors.end()) return "";
      const Spread spread = spread_of(found->second);
      cells.push_back(fmt::format("{:.1f} ({:.1f} .. {:.1f})", spread.median, spread.low, spread.high));
    }
    table.add(std::move(cells));
  }
  return table.text();
}

void add_map(Device& device, const std::string& path, const AccuracyDocumentOptions& options, MapTable (&tables)[2],
             MapErrors& errors_of_all) {
  const std::string name = std::filesystem::path(path).filename().string();
  NormalMap map;
  try {
    map = read_normal_map(path, {}, options.threads, nullptr);
  } catch (const Error&) {
    return;  // the file is not a normal map, and `multum bake` rejects it too
  }
  if (map.report.encoding.find("height field") != std::string::npos) return;
  std::printf("%s\n", name.c_str());
  const std::vector<double> exponents = {20.0, 100.0, 500.0};
  std::map<std::pair<int, double>, BaselineRow> best;
  for (const BaselineRow& row : measure_baselines(map, exponents, options.threads)) {
    const auto key = std::pair(row.level, row.exponent);
    if (row.level > 0) errors_of_all[{baseline_name(row.baseline), row.exponent}].push_back(row.error * 100.0);
    if (row.baseline == Baseline::kMip) continue;
    if (!best.contains(key) || row.error < best.at(key).error) best[key] = row;
  }
  const int level_count = mip_level_count(map.width, map.height);
  const auto add_to_all = [&](int lobes, const Errors& errors) {
    for (const double s : exponents)
      for (int level = 1; level < level_count; ++level)
        errors_of_all[{fmt::format("{} lobe{}", lobes, lobes == 1 ? "" : "s"), s}].push_back(
            *errors.at(level, AccuracyPoint::kCentre, fmt::format("blinn-phong:{}", s)));
  };
  for (const int lobes : {1, 2})
    add_to_all(lobes, measure(device, map, nullptr, {"", with_lobes(lobes)}, options.threads));
  const int lobe_counts[2] = {4, 6};
  for (int t = 0; t < 2; ++t) {
    const Errors errors = measure(device, map, nullptr, {"", with_lobes(lobe_counts[t])}, options.threads);
    add_to_all(lobe_counts[t], errors);
    for (double s : exponents) {
      tables[t].rows += fmt::format("| {} | {} |", name, s);
      for (int level = 0; level < level_count; ++level) {
        const double ours = *errors.at(level, AccuracyPoint::kCentre, fmt::format("blinn-phong:{}", s));
        const BaselineRow& other = best.at({level, s});
        const bool worse = ours > other.error * 100.0 + 0.05;
        if (level > 0) ++tables[t].cells;
        tables[t].rows += fmt::format(" {0}{1:.1f}{0}/{2:.1f} |", worse ? "**" : "", ours, other.error * 100.0);
        if (!worse || level == 0) continue;
        ++tables[t].worse;
        tables[t].losses +=
            fmt::format("- {}, s = {}, level {}: the error is {:.1f} % with lobes and {:.1f} % with {}\n", name, s,
                        level, ours, other.error * 100.0, baseline_name(other.baseline));
      }
      tables[t].rows += "\n";
    }
  }
}

std::string maps_section(Device& device, const AccuracyDocumentOptions& options) {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(options.maps))
    if (entry.is_regular_file()) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  MapTable tables[2];
  MapErrors errors;
  for (const std::string& path : paths) add_map(device, path, options, tables, errors);
  std::string text =
      "The tables cover every file of the test folder that `multum bake` reads as a normal map. The tables list errors "
      "at the centres of all texels of every level. Each cell contains two errors in %. The first error is the error "
      "of multum's lobes. The second error is the lowest error among Toksvig, LEAN and LEAN with its Jacobian. The "
      "first error is bold if it exceeds the second error by more than 0.05 points. All methods store normals in 16 "
      "bits, and moments as floats. Level 0 is not counted, because a texel of level 0 covers only one normal.\n\n"
      "### By channels\n\n"
      "The table lists medians over all maps and their levels from 1 on. Brackets contain the first and third "
      "quartile. Each combination of map and level counts once. A lobe needs four channels, and LEAN needs "
      "five. Averaged normals and Toksvig's rule need three channels, because the length of an averaged normal "
      "shows how much the normals vary.\n\n" +
      equal_channels_table(errors);
  const int lobe_counts[2] = {4, 6};
  for (int t = 0; t < 2; ++t) {
    text += fmt::format("\n### {} lobes: higher errors in {} of {} cells\n\n{}\n", lobe_counts[t], tables[t].worse,
                        tables[t].cells, tables[t].losses);
    text +=
        "| map | s | 0 | 1 | 2 | 3 | 4 | 5 | 6 | 7 | 8 | 9 | 10 "
        "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n" +
        tables[t].rows;
  }
  return text;
}

// Makes a table with one row per setting and one column of errors per BRDF.
std::string errors_table(const TradeoffResult& result) {
  MarkdownTable table({"settings", "shaded as", "s = 20", "s = 100", "s = 500", "Lambert", "bake, processor ms",
                       "elapsed, ms", "GPU, MB"});
  for (const TradeoffRow& row : result.rows) {
    if (!row.is_measured) continue;
    std::vector<std::string> cells = {"`" + row.options + "`",
                                      row.view.empty() ? "" : row.view.substr(row.view.find(' '))};
    for (const char* brdf : {"blinn-phong:20", "blinn-phong:100", "blinn-phong:500", "lambert"}) {
      const ReachedError one = reached_error(row.errors, parse_target_brdf(brdf));
      cells.push_back(fmt::format("{:.2f} ± {:.2f}", 100.0 * one.error, 100.0 * one.confidence));
    }
    cells.push_back(fmt::format("{:.0f}", 1e3 * row.bake.processor_seconds));
    cells.push_back(fmt::format("{:.0f}", 1e3 * row.bake.elapsed_seconds));
    cells.push_back(fmt::format("{:.2f}", static_cast<double>(row.gpu_bytes) / 1e6));
    table.add(std::move(cells));
  }
  return table.text();
}

// Bakes every representation and measures its errors with the code of `multum tradeoff`.
std::string representations_section(Device& device, const AccuracyDocumentOptions& options) {
  const ScratchFolder scratch("");
  TradeoffJob job;
  job.output = scratch / "sweep.html";
  job.bake.threads = options.threads;
  job.measures_all_brdfs = true;
  const auto sweep = [&](const std::string& name, const std::string& path) {
    std::printf("%s, every representation\n", name.c_str());
    job.bake.input = path;
    const TradeoffResult result = run_tradeoff(job, device, nullptr);
    return fmt::format("\n### Every representation: {}, {} x {}\n\n", name, result.width, result.height) +
           errors_table(result);
  };
  job.bake.reading.green = GreenAxis::kUp;
  if (options.is_quick) job.length = SweepLength::kQuick;
  write_four_quarter_map(std::min(options.size, 512), 7, scratch / "quarters");
  std::string text =
      std::string(
          "The rows are the settings that `multum tradeoff` measures. Each BRDF column lists the pixel error (relative "
          "L1 error in %) and half of the width of its 95 % interval ([ALGORITHMS](../contributing/ALGORITHMS.md), "
          "\"Measured error\"). Pixels are drawn with the default filter of that commit: ") +
      default_filter_text() +
      ".\n\nTimes include fitting or averaging, rounding and writing. Each time is the shortest time of three "
      "bakes. The bakes of the settings ran alternately, and all kernels were compiled before the timed bakes.\n" +
      sweep("four-quarter map", scratch / "quarters_normal.png");
  job.bake.reading.green.reset();
  job.length = SweepLength::kQuick;
  if (!options.maps.empty())
    for (const char* map : {"gd_aluminium_normal.png", "pm_0007.webp", "re_cyberhandwoven_n.png"})
      if (const std::string path = options.maps + "/normal/" + map; std::filesystem::exists(path))
        text += sweep(map, path);
  return text;
}

// Returns the sections of an existing document, with their second-level headings as keys. The key of the text before
// the first heading is "".
std::map<std::string, std::string> sections_of(const std::string& path) {
  std::map<std::string, std::string> sections;
  std::ifstream file(path);
  std::string heading;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) heading = line.substr(3);
    sections[heading] += line + "\n";
  }
  return sections;
}

}  // namespace

int write_accuracy_document(const AccuracyDocumentOptions& options) {
  const std::string commit = stated_commit(options.output, options.commit, options.allow_dirty);
  Device device = Device::open("");
  const std::map<std::string, std::string> there = sections_of(options.output);
  const std::string made_by = fmt::format("Measured at {} on {}, {}, with the OpenCL device {}.\n\n", commit,
                                          processor_name(), system_name(), device.info().name);
  std::string text =
      "# Accuracy\n\nThis page lists the errors of lobes, of other methods and of the shading formulas for "
      "single texels.\n\nGenerated by `multum-bench accuracy -o docs/evidence/ACCURACY.md`. The option `--section` "
      "regenerates one section. Do not edit.\n\nErrors are relative L1 errors in %: `sum |model - reference| / sum "
      "reference`. The sums run over all texels of a level and over 12 half vectors. The half vectors combine the "
      "lights (.3,.2,.93) (-.7,.1,.7) (.1,-.9,.45) (.5,.6,.6) with the views (0,0,1) (.6,0,.8) (-.3,.7,.6). For "
      "Lambert, the sums run over the four lights.\n\n- The BRDF is `(s+1)/(2 pi) t^s`, where t is the cosine between "
      "the normal and the half vector. Only the convolution is measured, without the factor `n . l`.\n- The reference "
      "is the average over all finest normals that a texel covers, computed in double precision.\n- The model "
      "consists of the stored lobes, which are filtered like a GPU filters textures, and shaded with the "
      "formulas of the runtime. Lobes are stored as snorm16 "
      "unless a row names another format.\n\n";
  const auto add = [&](const std::string& name, const std::string& heading, const auto& make) {
    const bool is_asked = options.sections.empty() ||
                          std::find(options.sections.begin(), options.sections.end(), name) != options.sections.end();
    const auto old = there.find(heading);
    if (is_asked) text += "## " + heading + "\n\n" + made_by + make() + "\n";
    else if (old != there.end()) text += old->second;
  };
  add("quarters", "The four-quarter map",
      [&] { return quarters_section(device, options) + first_level_section(device, options); });
  add("representations", "Every representation", [&] { return representations_section(device, options); });
  add("formulas", "Errors of the formulas", [&] { return formula_section(device, options.brdfs); });
  add("maps", "Real normal maps", [&] { return options.maps.empty() ? "" : maps_section(device, options); });
  while (text.ends_with("\n\n")) text.pop_back();
  write_text_file(options.output, text);
  std::printf("%s: written\n", options.output.c_str());
  return 0;
}

}  // namespace multum::bench
