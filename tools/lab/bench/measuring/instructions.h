// SPDX-License-Identifier: Apache-2.0
// Chooses the vector instructions of a benchmark: the processor's widest, or AVX2 on a processor with AVX-512, so that
// one machine can measure both.
#pragma once

#include <optional>

namespace multum::bench {

enum class Instructions { kAvx2, kAvx512 };

/// Returns "AVX2" or "AVX-512".
const char* instructions_name(Instructions instructions);

/// Returns `asked`, or the processor's widest instructions if `asked` is not set. Throws Error(kEnvironment) if the
/// processor does not have these instructions.
Instructions choose_instructions(std::optional<Instructions> asked);

/// Makes PoCL compile for `instructions`, in this process and its children. Call it before the first search for
/// devices.
void limit_opencl(Instructions instructions);

}  // namespace multum::bench
