// SPDX-License-Identifier: Apache-2.0
#include "host/formats/opencl/pocl_settings.h"

#include <cstdlib>

#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

// The first name is for PoCL before 4.0, and the second name is for 4.0 and later.
constexpr const char* kThreadVariables[] = {"POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT"};

}  // namespace

// By default, PoCL compiles a kernel again for each local size at its first launch, although the program has a version
// for all sizes. This takes seconds in a first bake. Compiling again does not make kernels with one work-item per group
// faster (PoCL 3.1, AVX-512: bakes of 1024 x 1024 took the same time).
void ask_pocl_for_one_version_of_kernels() {
  [[maybe_unused]] static const bool asked = prefer_environment("POCL_WORK_GROUP_SPECIALIZATION", "0", false);
}

void set_pocl_threads(int threads) {
  for (const char* variable : kThreadVariables) prefer_environment(variable, std::to_string(threads), true);
}

void ask_pocl_for_usual_threads() {
  for (const char* variable : kThreadVariables)
    if (std::getenv(variable) != nullptr) return;
  set_pocl_threads(processor_count());
}

bool pocl_loops_may_abort(const std::string& platform_version) {
  return platform_version.find(" PoCL ") != std::string::npos &&
         platform_version.find(" LLVM 18.") != std::string::npos;
}

// With continuations (PoCL 6.0, haswell and skylake-avx512), bakes had the same bytes and took the same time.
void ask_pocl_for_safe_loops(const std::string& platform_version) {
  if (pocl_loops_may_abort(platform_version))
    require_environment("POCL_WORK_GROUP_METHOD", "cbs",
                        "PoCL with LLVM 18 can terminate the process while compiling loops");
}

}  // namespace multum
