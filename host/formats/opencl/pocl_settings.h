// SPDX-License-Identifier: Apache-2.0
// Asks PoCL, by environment variables that it reads, to compile kernels in the ways that they need. A variable that the
// user has set is left as it is.
#pragma once

#include <string>

namespace multum {

/// What is right for every version of PoCL; called before the first platform is asked for.
void ask_pocl_for_one_version_of_kernels();

/// Has PoCL run kernels by so many threads, whatever the environment said. Called before the first platform is asked
/// for.
void set_pocl_threads(int threads);

/// The same, with as many threads as this process can run at once (processor_count()), where neither the user nor
/// set_pocl_threads() has said how many: PoCL itself counts the machine's processors, and not those that a container
/// leaves.
void ask_pocl_for_usual_threads();

/// Whether PoCL of this CL_PLATFORM_VERSION may give up while it joins work-items by loops, its usual way: behind LLVM
/// 18 it ends the program ("Instruction Combining did not reach a fixpoint", pocl issue 1608), which was seen for
/// processors without AVX-512 and not for those with it.
[[nodiscard]] bool pocl_loops_may_abort(const std::string& platform_version, bool has_avx512);

/// Asks PoCL of this CL_PLATFORM_VERSION to join work-items by continuations where its loops may abort. Called before
/// the first kernel is compiled.
void ask_pocl_for_safe_loops(const std::string& platform_version);

}  // namespace multum
