// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/batch_benchmark.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

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

// The maps of one size, and the names of all outputs.
struct Maps {
  std::vector<std::string> inputs, baked, slopes;
};

Maps make_maps(const ScratchFolder& folder, int size, int count, Progress* progress) {
  Maps maps;
  for (int i = 0; i < count; ++i) {
    const std::string stem = fmt::format("map{}", i + 1);
    maps.inputs.push_back(make_map_file(folder / stem, size, i + 1, progress));
    maps.baked.push_back(folder / ("out/" + stem + "_normal.ndf.exr"));
    maps.slopes.push_back(folder / (stem + "_slopes.exr"));
  }
  return maps;
}

std::vector<std::string> batch_command(const BatchBenchmarkOptions& options, const Maps& maps,
                                       const std::string& folder) {
  std::vector<std::string> command =
      multum_bake_command(maps.inputs.front(), folder, {options.lobes, options.threads, "", options.bake_options});
  const auto after_first = std::find(command.begin(), command.end(), maps.inputs.front()) + 1;
  command.insert(after_first, maps.inputs.begin() + 1, maps.inputs.end());
  return command;
}

ProgramCost run_maketx(const Maps& maps, int threads, Progress* progress) {
  ProgramCost all{};
  for (std::size_t i = 0; i < maps.inputs.size(); ++i) {
    const ProgramCost one =
        run_to_disk(maketx_command(maps.inputs[i], maps.slopes[i], threads), maps.slopes[i], progress);
    all.wall_seconds += one.wall_seconds;
    all.cpu_seconds += one.cpu_seconds;
    all.peak_mib = std::max(all.peak_mib, one.peak_mib);
    all.output_mb += one.output_mb;
  }
  return all;
}

std::string hash_of(const Maps& maps) {
  ContentHash all;
  for (const std::string& baked : maps.baked) all.update(read_movmf_header(baked).header.provenance.content_hash);
  return all.finish();
}

Json run_size(const BatchBenchmarkOptions& options, int size, const Maps& maps, const std::string& folder,
              Progress* progress) {
  const std::vector<std::string> command = batch_command(options, maps, folder);
  std::vector<ProgramCost> ours, theirs;
  std::vector<double> rates, wall, cpu;
  std::string content_hash;
  for (int i = 0; i < options.repetitions; ++i) {
    ours.push_back(run_to_disk(command, maps.baked, progress));
    const std::string found = hash_of(maps);
    if (i > 0 && found != content_hash)
      throw Error(ErrorCode::kVerification, fmt::format("{0} x {0}: two runs gave different pixels", size));
    content_hash = found;
    theirs.push_back(run_maketx(maps, options.threads, progress));
    rates.push_back(options.count / ours.back().wall_seconds);
    wall.push_back(ours.back().wall_seconds / theirs.back().wall_seconds);
    cpu.push_back(ours.back().cpu_seconds / theirs.back().cpu_seconds);
    fmt::print(stderr, "{0} x {0}, pair {1} of {2}: multum bake {3} s, maketx {4} s\n", size, i + 1,
               options.repetitions, rounded_text(ours.back().wall_seconds), rounded_text(theirs.back().wall_seconds));
  }
  return {{"size", size},
          {"content_hash", content_hash},
          {"multum", costs_json(ours)},
          {"maketx", costs_json(theirs)},
          {"maps_per_s", spread_json(spread_of(rates))},
          {"ratio", {{"wall", spread_json(spread_of(wall))}, {"cpu", spread_json(spread_of(cpu))}}}};
}

}  // namespace

Json run_batch_benchmark(const BatchBenchmarkOptions& options, Progress* progress) {
  if (options.size_max < options.size_min)
    throw Error(ErrorCode::kUsage,
                fmt::format("--size-max is {}, expected at least --size-min, {}", options.size_max, options.size_min));
  if (options.instructions) limit_opencl(choose_instructions(options.instructions));
  const std::string version = maketx_version();
  const ScratchFolder folder(options.folder);
  std::filesystem::create_directory(folder / "out");
  const std::string report = folder / "report.json";
  Json sizes = Json::array();
  ContentHash all;
  for (int size = options.size_min; size <= options.size_max; size *= 2) {
    const Maps maps = make_maps(folder, size, options.count, progress);
    run_to_disk(multum_bake_command(maps.inputs.front(), maps.baked.front(),
                                    {options.lobes, options.threads, report, options.bake_options}),
                maps.baked.front(), progress);
    run_maketx(maps, options.threads, progress);
    sizes.push_back(run_size(options, size, maps, folder / "out/", progress));
    all.update(sizes.back().at("content_hash").get<std::string>());
  }
  const std::vector<std::string> shown =
      multum_bake_command("MAPS", "out/", {options.lobes, options.threads, "", options.bake_options});
  Json result = {{"device", device_of_report(report)},
                 {"file_system", file_system_name(folder.path())},
                 {"lobes", options.lobes},
                 {"count", options.count},
                 {"repetitions", options.repetitions},
                 {"version", version},
                 {"result_hash", all.finish()}};
  if (options.instructions) result["instructions"] = instructions_name(*options.instructions);
  result["multum_command"] = command_text(shown);
  result["maketx_command"] = command_text(maketx_command("MAP", "map_slopes.exr", options.threads));
  result["sizes"] = std::move(sizes);
  return result;
}

ResultView view_batch(const Json& result) {
  const double count = result.at("count").get<int>();
  MarkdownTable table({"side", "maps per s", "CPU per map, s", "CPU per map, maketx, s", "ratio of CPU",
                       "ratio of wall time", "peak memory, MiB", "output per map, MB"});
  for (const Json& row : result.at("sizes")) {
    const auto median = [&](const char* program, const char* key) {
      return parse_spread(row.at(program).at(key)).median;
    };
    table.add({std::to_string(row.at("size").get<int>()), spread_text(parse_spread(row.at("maps_per_s"))),
               rounded_text(median("multum", "cpu_s") / count), rounded_text(median("maketx", "cpu_s") / count),
               spread_text(parse_spread(row.at("ratio").at("cpu"))),
               spread_text(parse_spread(row.at("ratio").at("wall"))), rounded_text(median("multum", "peak_mib")),
               rounded_text(median("multum", "output_mb") / count)});
  }
  return {fmt::format("Many small maps{}",
                      result.contains("instructions") ? ", " + result["instructions"].get<std::string>() : ""),
          fmt::format("For each side, `{}` bakes {} four-quarter maps with different seeds from 16-bit PNGs, in one "
                      "process, and `{}` (OpenImageIO {}) converts each of the maps in a process of its own. Files are "
                      "synced to disk ({}). After an untimed run, the programs ran in {} pairs. *CPU* is user and "
                      "system time, and the ratios compare the runs of a pair.",
                      result.at("multum_command").get<std::string>(), result.at("count").get<int>(),
                      result.at("maketx_command").get<std::string>(), result.at("version").get<std::string>(),
                      result.at("file_system").get<std::string>(), result.at("repetitions").get<int>()),
          table.text()};
}

}  // namespace multum::bench
