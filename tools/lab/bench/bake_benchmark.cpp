// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/bake_benchmark.h"

#include <fmt/format.h>

#include <array>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/error.h"
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

// Checks that every run of multum produces the same pixels as the first run. This ensures that all times are for the
// same work.
void check_same(std::string& first, const std::string& path) {
  const std::string found = read_movmf_header(path).header.provenance.content_hash;
  if (first.empty()) first = found;
  if (found != first)
    throw Error(ErrorCode::kVerification,
                fmt::format("{}: checksum {}, expected {} as in the previous run", path, found, first));
}

Json pair_ratios(const std::vector<ProgramCost>& ours, const std::vector<ProgramCost>& theirs) {
  std::vector<double> wall, cpu, memory, output;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    wall.push_back(ours[i].wall_seconds / theirs[i].wall_seconds);
    cpu.push_back(ours[i].cpu_seconds / theirs[i].cpu_seconds);
    memory.push_back(ours[i].peak_mib / theirs[i].peak_mib);
    output.push_back(ours[i].output_mb / theirs[i].output_mb);
  }
  return {{"wall", spread_json(spread_of(wall))},
          {"cpu", spread_json(spread_of(cpu))},
          {"peak", spread_json(spread_of(memory))},
          {"output", spread_json(spread_of(output))}};
}

std::vector<std::string> row_of(const std::string& name, const Json& values, std::array<const char*, 4> keys) {
  std::vector<std::string> row = {name};
  for (const char* key : keys) row.push_back(spread_text(parse_spread(values.at(key))));
  return row;
}

}  // namespace

Json run_bake_benchmark(const BakeBenchmarkOptions& options, Progress* progress) {
  if (options.instructions) limit_opencl(choose_instructions(options.instructions));
  const std::string version = maketx_version();
  const ScratchFolder folder(options.folder);
  const std::string map = make_map_file(folder.path(), options.size, progress);
  const std::string baked = folder / "map.ndf.exr", slopes = folder / "map_slopes.exr", report = folder / "report.json";
  const BakeCommandOptions bake{options.lobes, options.threads, "", options.bake_options};
  BakeCommandOptions warm_up = bake;
  warm_up.report = report;
  const std::vector<std::string> ours = multum_bake_command(map, baked, bake);
  const std::vector<std::string> theirs = maketx_command(map, slopes, options.threads);
  run_to_disk(multum_bake_command(map, baked, warm_up), baked, progress);
  run_to_disk(theirs, slopes, progress);
  std::string content_hash;
  std::vector<ProgramCost> our_costs, their_costs;
  for (int i = 0; i < options.repetitions; ++i) {
    our_costs.push_back(run_to_disk(ours, baked, progress));
    check_same(content_hash, baked);
    their_costs.push_back(run_to_disk(theirs, slopes, progress));
    fmt::print(stderr, "pair {} of {}: multum bake {} s, maketx {} s\n", i + 1, options.repetitions,
               rounded_text(our_costs.back().wall_seconds), rounded_text(their_costs.back().wall_seconds));
  }
  Json result = {{"device", device_of_report(report)},
                 {"file_system", file_system_name(folder.path())},
                 {"size", options.size},
                 {"lobes", options.lobes},
                 {"repetitions", options.repetitions},
                 {"result_hash", content_hash}};
  if (options.instructions) result["instructions"] = instructions_name(*options.instructions);
  result["programs"] = {{{"name", "multum bake"}, {"command", command_text(ours)}},
                        {{"name", "maketx"}, {"command", command_text(theirs)}, {"version", version}}};
  result["programs"][0].update(costs_json(our_costs));
  result["programs"][1].update(costs_json(their_costs));
  result["ratio"] = pair_ratios(our_costs, their_costs);
  return result;
}

ResultView view_bake(const Json& result) {
  const Json& programs = result.at("programs");
  const Json &ours = programs.at(0), &theirs = programs.at(1);
  MarkdownTable table({"program", "wall, s", "CPU, s", "peak memory, MiB", "output, MB"});
  constexpr std::array<const char*, 4> kCosts = {"wall_s", "cpu_s", "peak_mib", "output_mb"};
  table.add(row_of(ours.at("name"), ours, kCosts));
  table.add(row_of(theirs.at("name"), theirs, kCosts));
  table.add(row_of("ratio", result.at("ratio"), {"wall", "cpu", "peak", "output"}));
  return {
      fmt::format("A whole bake compared with maketx, {0} x {0}{1}", result.at("size").get<int>(),
                  result.contains("instructions") ? ", " + result["instructions"].get<std::string>() : ""),
      fmt::format("Both programs read the four-quarter map from a 16-bit PNG and write a file that is synced to disk "
                  "({}). A is `{}`. B is `{}` (OpenImageIO {}). After one untimed run of each program, A and B ran in "
                  "{} pairs, and each ratio compares the two runs of a pair. *CPU* is user and system time. maketx "
                  "reads the PNG's normals as signed numbers, so only its costs can be compared, not its slopes.",
                  result.at("file_system").get<std::string>(), ours.at("command").get<std::string>(),
                  theirs.at("command").get<std::string>(), theirs.at("version").get<std::string>(),
                  result.at("repetitions").get<int>()),
      table.text()};
}

}  // namespace multum::bench
