// SPDX-License-Identifier: Apache-2.0
#include "tools/bench/result_file.h"

#include <fmt/format.h>

#include <utility>

#include "host/base/error.h"
#include "tools/bench/bake_benchmark.h"
#include "tools/bench/build_info.h"
#include "tools/bench/em_benchmark.h"
#include "tools/bench/load_benchmark.h"
#include "tools/bench/machine.h"
#include "tools/bench/scale_benchmark.h"

namespace multum::bench {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::pair<const char*, ResultView (*)(const Json&)> kViews[] = {
    {"em", view_em}, {"bake", view_bake}, {"scale", view_scale}, {"load", view_load}};

}  // namespace

Json make_result(const std::string& benchmark, const std::string& command, const Json& figures) {
  Json result = {{"benchmark", benchmark},         {"command", command},
                 {"commit", built_commit()},       {"compiler", compiler_name()},
                 {"processor", processor_name()},  {"cores", core_count()},
                 {"memory_bytes", memory_bytes()}, {"system", system_name()}};
  result.update(figures);
  return result;
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

}  // namespace multum::bench
