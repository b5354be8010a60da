// SPDX-License-Identifier: Apache-2.0
#include "host/lab/selftest/selftest.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "host/foundation/base/error.h"
#include "host/lab/selftest/case_lists.h"

namespace multum {
namespace {

bool is_wanted(const NumericalCase& c, const std::string& filter) {
  return c.text.name.find(filter) != std::string::npos || c.text.formula.find(filter) != std::string::npos;
}

// A case that compares no values must fail. Otherwise it would pass for any kernel.
double worst_of(const WorstError& worst) {
  return worst.count() > 0 ? worst.value() : std::numeric_limits<double>::quiet_NaN();
}

double edited_error(const NumericalCase& the_case, Device& device, const std::vector<SourceEdit>& edits) {
  device.edit_kernels(edits);
  const auto restore = [&device](void*) { device.edit_kernels({}); };
  const std::unique_ptr<void, decltype(restore)> restored(&device, restore);
  WorstError worst;
  the_case.run(device, worst);
  return worst_of(worst);
}

using CaseList = std::vector<NumericalCase> (*)();

std::vector<CaseList>& registered_lists() {
  static std::vector<CaseList> lists;
  return lists;
}

}  // namespace

void register_numerical_cases(CaseList list) {
  std::vector<CaseList>& lists = registered_lists();
  if (std::find(lists.begin(), lists.end(), list) == lists.end()) lists.push_back(list);
}

const std::vector<NumericalCase>& numerical_cases() {
  static const std::vector<NumericalCase> cases = [] {
    std::vector<NumericalCase> all;
    std::vector<CaseList> lists = {numerics_cases, em_cases,       choose_cases,  refine_cases, planar_cases,
                                   level_cases,    sum_cases,      shading_cases, sh_cases,     pyramid_cases,
                                   moment_cases,   one_lobe_cases, plane_cases,   block_cases};
    lists.insert(lists.end(), registered_lists().begin(), registered_lists().end());
    lists.push_back(storage_cases);
    for (const CaseList part : lists)
      for (NumericalCase& c : part()) all.push_back(std::move(c));
    return all;
  }();
  return cases;
}

NumericalVerdict run_case(const NumericalCase& the_case, Device& device, bool without_guard) {
  WorstError worst;
  the_case.run(device, worst);
  NumericalVerdict verdict{the_case.text, worst_of(worst), worst.input(), {}, {}};
  if (!without_guard) return verdict;
  if (the_case.naive) {
    WorstError naive;
    the_case.naive(naive);
    verdict.without_guard = worst_of(naive);
  }
  for (const SourceEdit& guard : the_case.without) {
    const double error = edited_error(the_case, device, {guard});
    verdict.without_guard = verdict.without_guard ? least_error(*verdict.without_guard, error) : error;
  }
  if (!the_case.mutation.empty()) verdict.mutated = edited_error(the_case, device, the_case.mutation);
  return verdict;
}

NumericalRun run_selftest(Device& device, const SelftestOptions& options, Progress* progress) {
  std::vector<const NumericalCase*> wanted;
  for (const NumericalCase& c : numerical_cases())
    if (is_wanted(c, options.filter)) wanted.push_back(&c);
  if (wanted.empty())
    throw Error(ErrorCode::kUsage, fmt::format("no case or kernel has '{}' in its name; expected a part of one of the "
                                               "{} names in docs/contributing/STABILITY.md",
                                               options.filter, numerical_cases().size()));
  NumericalRun run{"OpenCL",
                   device.info().name,
                   device.info().platform,
                   "driver " + device.info().driver,
                   std::string("multum ") + MULTUM_VERSION,
                   {}};
  progress_start(progress, wanted.size());
  for (const NumericalCase* c : wanted) {
    progress_stage(progress, c->text.name);
    run.verdicts.push_back(run_case(*c, device, options.without_guards));
    progress_advance(progress, 1);
  }
  return run;
}

}  // namespace multum
