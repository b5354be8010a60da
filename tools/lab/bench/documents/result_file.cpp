// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/result_file.h"

#include <fmt/format.h>

#include <fstream>
#include <utility>

#include "host/foundation/base/error.h"
#include "tools/lab/bench/bake_benchmark.h"
#include "tools/lab/bench/batch_benchmark.h"
#include "tools/lab/bench/build_info.h"
#include "tools/lab/bench/em_benchmark.h"
#include "tools/lab/bench/filter_benchmark.h"
#include "tools/lab/bench/frames_benchmark.h"
#include "tools/lab/bench/inference_benchmark.h"
#include "tools/lab/bench/load_benchmark.h"
#include "tools/lab/bench/measuring/machine.h"
#include "tools/lab/bench/scale_benchmark.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::pair<const char*, ResultView (*)(const Json&)> kViews[] = {
    {"em", view_em},     {"bake", view_bake},       {"batch", view_batch},   {"scale", view_scale},
    {"load", view_load}, {"infer", view_inference}, {"frames", view_frames}, {"filters", view_filters}};

}  // namespace

Json make_result(const std::string& benchmark, const std::string& command, const Json& figures) {
  Json result = {{"benchmark", benchmark},         {"command", command},
                 {"commit", built_commit()},       {"compiler", compiler_name()},
                 {"processor", processor_name()},  {"cores", core_count()},
                 {"memory_bytes", memory_bytes()}, {"system", system_name()}};
  result.update(figures);
  return result;
}

std::string conditions_text(const Json& result) {
  return fmt::format("The program was built from commit {} ({}), and ran on {}, {} cores, {:.0f} GiB of memory, {}.",
                     result.at("commit").get<std::string>(), result.at("compiler").get<std::string>(),
                     result.at("processor").get<std::string>(), result.at("cores").get<int>(),
                     result.at("memory_bytes").get<double>() / (1 << 30), result.at("system").get<std::string>());
}

ResultView view_of(const Json& result) {
  const auto name = result.at("benchmark").get<std::string>();
  std::string known;
  for (const auto& [benchmark, view] : kViews) {
    if (name == benchmark) return view(result);
    known += std::string(known.empty() ? "" : ", ") + benchmark;
  }
  throw Error(ErrorCode::kInput, fmt::format("found the benchmark '{}', expected one of {}", name, known));
}

Json read_result(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw Error(ErrorCode::kInput, "cannot read " + path + ": expected a file of multum-bench --json");
  try {
    const Json result = Json::parse(in);
    view_of(result);
    conditions_text(result);
    for (const char* key : {"command", "device", "result_hash"}) result.at(key).get<std::string>();
    return result;
  } catch (const Error& error) {
    throw Error(ErrorCode::kInput, path + ": " + error.what());
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kInput, path + ": " + error.what() + "; expected a file of multum-bench --json");
  }
}

}  // namespace multum::bench
