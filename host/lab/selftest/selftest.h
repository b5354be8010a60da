// SPDX-License-Identifier: Apache-2.0
// The numerical cases of the OpenCL kernels, run on the user's own device and driver: `multum selftest`, the tests of
// tests/hard_cases, and docs/contributing/STABILITY.md all run this one registry.
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
  /// Adds an error for each input to the worst. Throws Error(kEnvironment) when the device refuses.
  std::function<void(Device& device, WorstError& worst)> run;
  /// What takes the guard out of the kernels' text: each edit one guard, tried by itself. Empty where the guard is no
  /// line of a kernel, or not one alone: then `naive` is there, or `mutation`.
  std::vector<SourceEdit> without;
  /// The naive formula in float on the host, on the same inputs; may be empty.
  std::function<void(WorstError& worst)> naive = {};
  /// A bug put into the kernels' text, all of these edits together; may be empty.
  std::vector<SourceEdit> mutation = {};
};

/// Adds a list of cases, once. For parts of the project that not every build has; before numerical_cases() is asked
/// for.
void register_numerical_cases(std::vector<NumericalCase> (*list)());

/// All of them, by the kernel that they are of. Names are unique.
const std::vector<NumericalCase>& numerical_cases();

struct SelftestOptions {
  std::string filter;           // cases whose name or kernel has this text in it; empty: all
  bool without_guards = false;  // each case again with its guard taken out, and with its bug
};

/// Runs the cases that the filter leaves, in their order. Throws Error(kUsage) when it leaves none. Progress: one unit
/// a case; cancels between cases.
NumericalRun run_selftest(Device& device, const SelftestOptions& options, Progress* progress);

/// One case. Kernels are as they were before when it returns.
NumericalVerdict run_case(const NumericalCase& the_case, Device& device, bool without_guard);

}  // namespace multum
