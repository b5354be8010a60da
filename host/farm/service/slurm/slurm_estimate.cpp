// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

using Json = nlohmann::json;

constexpr auto kEstimateTimeMax = std::chrono::seconds(20);
constexpr std::uint64_t kEstimateMemoryMax = std::uint64_t{512} << 20;
constexpr std::size_t kEstimateOutputMax = 1 << 20;

SlurmEstimate estimate_of(const Json& plan, const SlurmSettings& settings) {
  SlurmEstimate estimate;
  estimate.seconds = plan.at("processor_seconds").get<double>() / settings.cpus;
  estimate.share_count = plan.at("shares").get<int>();
  if (estimate.share_count == 0) return estimate;
  const auto bands = plan.at("band_seconds").get<std::vector<double>>();
  for (const double seconds : {plan.at("coarse_seconds").get<double>(), *std::max_element(bands.begin(), bands.end()),
                               plan.at("merge_seconds").get<double>()})
    estimate.share_seconds.push_back(seconds / settings.cpus);
  return estimate;
}

}  // namespace

SlurmEstimate estimate_work(const WorkOrder& work, const SlurmSettings& settings,
                            const std::vector<std::string>& roots) {
  SlurmEstimate estimate;
  if (!work.copy_from.empty()) return estimate;
  try {
    const JobType& type = find_job_type(work.type);
    if (type.estimated_seconds != nullptr) estimate.seconds = type.estimated_seconds(work.parameters);
    if (type.estimate_command.empty()) return estimate;
    std::vector<std::string> words = {own_program(), "confined"};
    for (const std::string& root : roots) words.push_back("--read=" + root);
    words.insert(words.end(), {"--", own_program(), type.estimate_command, "--json", "--threads=1",
                               fmt::format("--share-seconds={}", settings.share_seconds)});
    const std::vector<std::string> arguments = job_arguments(type, work.parameters, "");
    words.insert(words.end(), arguments.begin() + 1, arguments.end());
    const ChildResult child = run_child(
        words, {.time_max = kEstimateTimeMax, .memory_max = kEstimateMemoryMax, .output_max = kEstimateOutputMax});
    if (child.exit_code == 0) return estimate_of(Json::parse(child.output.substr(child.output.find('{'))), settings);
  } catch (const std::exception&) {  // the job itself will report the error
  }
  return estimate;
}

}  // namespace multum
