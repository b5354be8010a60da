// SPDX-License-Identifier: Apache-2.0
// Chooses the vector instructions of a benchmark: the processor's widest, or AVX2 where it has AVX-512 too, so that one
// machine tells of both.
#pragma once

#include <optional>

namespace multum::bench {

enum class Instructions { kAvx2, kAvx512 };

/// "AVX2", "AVX-512".
const char* instructions_name(Instructions instructions);

/// `asked`, or the widest that the processor has. Throws Error(kEnvironment) when it lacks them.
Instructions choose_instructions(std::optional<Instructions> asked);

/// Has PoCL compile for `instructions`, in this process and its children. Before the first device is looked for.
void limit_opencl(Instructions instructions);

}  // namespace multum::bench
