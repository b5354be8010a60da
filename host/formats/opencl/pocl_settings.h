// SPDX-License-Identifier: Apache-2.0
// Sets environment variables so that PoCL compiles kernels as this project needs. Variables that the user has set stay
// unchanged.
#pragma once

#include <string>

namespace multum {

/// These settings apply to every version of PoCL. Call this function before using the first platform.
void ask_pocl_for_one_version_of_kernels();

/// Makes PoCL run kernels with this many threads, and overrides the environment. Call it before using the first
/// platform.
void set_pocl_threads(int threads);

/// Sets the number of threads to the number that this process can run at once (processor_count()), unless the user or
/// set_pocl_threads() has set it. PoCL itself counts the processors of the machine and ignores the limit of a
/// container.
void ask_pocl_for_usual_threads();

/// Returns whether a PoCL with this CL_PLATFORM_VERSION can abort when it joins work-items by loops, which is its
/// default. With LLVM 18, some kernels end the program ("Instruction Combining did not reach a fixpoint", pocl issue
/// 1608).
[[nodiscard]] bool pocl_loops_may_abort(const std::string& platform_version);

/// Makes a PoCL with this CL_PLATFORM_VERSION join work-items by continuations if its loops may abort. Call this
/// function before compiling the first kernel.
void ask_pocl_for_safe_loops(const std::string& platform_version);

}  // namespace multum
