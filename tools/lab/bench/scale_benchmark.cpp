// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/scale_benchmark.h"

#include <fmt/format.h>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "tools/lab/bench/documents/markdown_table.h"
#include "tools/lab/bench/measuring/bake_programs.h"
#include "tools/lab/bench/measuring/command_text.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/measuring/measured_program.h"
#include "tools/lab/bench/measuring/scratch_folder.h"
#include "tools/lab/bench/measuring/statistics.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

// For sizes up to this limit, a cold start would affect the times. The first run of such a size is therefore not timed.
constexpr int kWarmUpSizeMax = 2048;

Json run_size(const ScaleBenchmarkOptions& options, int size, const std::string& map, const std::string& baked,
              Progress* progress) {
  const std::vector<std::string> command =
      multum_bake_command(map, baked, {options.lobes, options.threads, "", options.bake_options});
  std::vector<ProgramCost> costs;
  for (int i = 0; i < options.repetitions; ++i) {
    costs.push_back(run_to_disk(command, baked, progress));
    fmt::print(stderr, "{0} x {0}, {1} of {2}: {3} s\n", size, i + 1, options.repetitions,
               rounded_text(costs.back().wall_seconds));
  }
  Json row = {{"size", size}, {"command", command_text(command)}};
  row.update(costs_json(costs));
  row["ns_per_texel"] = parse_spread(row["wall_s"]).median * 1e9 / (static_cast<double>(size) * size);
  row["content_hash"] = read_movmf_header(baked).header.provenance.content_hash;
  return row;
}

std::string ratio_text(const Json& row, const Json* before, const char* key) {
  if (before == nullptr) return "-";
  return rounded_text(parse_spread(row.at(key)).median / parse_spread(before->at(key)).median);
}

}  // namespace

Json run_scale_benchmark(const ScaleBenchmarkOptions& options, Progress* progress) {
  if (options.size_max < options.size_min)
    throw Error(ErrorCode::kUsage,
                fmt::format("--size-max is {}, expected at least --size-min, {}", options.size_max, options.size_min));
  const ScratchFolder folder(options.folder);
  const std::string baked = folder / "map.ndf.exr", report = folder / "report.json";
  const BakeCommandOptions warm_up{options.lobes, options.threads, report, options.bake_options};
  Json sizes = Json::array();
  for (int size = options.size_min; size <= options.size_max; size *= 2) {
    const std::string map = make_map_file(folder.path(), size, progress);
    if (size == options.size_min || size <= kWarmUpSizeMax)
      run_to_disk(multum_bake_command(map, baked, warm_up), baked, progress);
    sizes.push_back(run_size(options, size, map, baked, progress));
  }
  ContentHash all;
  for (const Json& row : sizes) all.update(row.at("content_hash").get<std::string>());
  return {{"device", device_of_report(report)},
          {"file_system", file_system_name(folder.path())},
          {"lobes", options.lobes},
          {"repetitions", options.repetitions},
          {"result_hash", all.finish()},
          {"sizes", sizes}};
}

ResultView view_scale(const Json& result) {
  MarkdownTable table({"side", "wall, s", "ratio to the row above", "ns per texel", "CPU, s", "peak memory, MiB",
                       "ratio to the row above", "output, MB"});
  const Json* before = nullptr;
  for (const Json& row : result.at("sizes")) {
    table.add({std::to_string(row.at("size").get<int>()), spread_text(parse_spread(row.at("wall_s"))),
               ratio_text(row, before, "wall_s"), rounded_text(row.at("ns_per_texel").get<double>()),
               spread_text(parse_spread(row.at("cpu_s"))), rounded_text(parse_spread(row.at("peak_mib")).median),
               ratio_text(row, before, "peak_mib"), rounded_text(parse_spread(row.at("output_mb")).median)});
    before = &row;
  }
  return {"Whole bakes of growing maps",
          fmt::format(
              "`{}` bakes the four-quarter map from a 16-bit PNG to a file that is synced to disk ({}). Each run "
              "starts a new process. The number of runs per size is {}. For sizes up to {} x {}, one untimed run comes "
              "first. If time is proportional to size, four times as many texels take four times as long.",
              result.at("sizes").at(0).at("command").get<std::string>(), result.at("file_system").get<std::string>(),
              result.at("repetitions").get<int>(), kWarmUpSizeMax, kWarmUpSizeMax),
          table.text()};
}

}  // namespace multum::bench
