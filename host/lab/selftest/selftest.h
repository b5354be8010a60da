// SPDX-License-Identifier: Apache-2.0
// Runs the numerical cases of the OpenCL kernels on the user's device and driver. `multum selftest`, the tests in
// tests/hard_cases, and docs/contributing/STABILITY.md use this registry.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "host/lab/reference/numerical_case.h"

namespace multum {

struct NumericalCase {
  NumericalCaseText text;
  /// Computes the error for each input, and updates the worst error. Throws Error(kEnvironment) for errors of the
  /// device.
  std::function<void(Device& device, WorstError& worst)> run;
  /// Edits of the kernels' source text. Each edit removes one guard and is tested separately. If the guard is not a
  /// single line of a kernel, this list is empty, and `naive` or `mutation` is set.
  std::vector<SourceEdit> without;
  /// Computes the naive formula in float on the host, with the same inputs. May be empty.
  std::function<void(WorstError& worst)> naive = {};
  /// Edits that together add a bug to the kernels' source text. May be empty.
  std::vector<SourceEdit> mutation = {};
};

/// Adds a list of cases. This function is for parts of the project that only some builds contain. Call it once per
/// list, before the first use of numerical_cases().
void register_numerical_cases(std::vector<NumericalCase> (*list)());

/// Returns all cases, ordered by kernel. Names are unique.
const std::vector<NumericalCase>& numerical_cases();

struct SelftestOptions {
  std::string filter;           // run only cases whose name or kernel contains this text; all cases if empty
  bool without_guards = false;  // also run each case with its guard removed, and with its bug
};

/// Runs the cases that match the filter, in their order. Throws Error(kUsage) if no case matches. Each case is one unit
/// of progress, and a run can be cancelled between cases.
NumericalRun run_selftest(Device& device, const SelftestOptions& options, Progress* progress);

/// Runs one case. Restores the kernels before it returns.
NumericalVerdict run_case(const NumericalCase& the_case, Device& device, bool without_guard);

}  // namespace multum
