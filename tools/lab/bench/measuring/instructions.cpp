// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/instructions.h"

#include <fmt/format.h>

#include <cstdlib>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

// Tests whether the processor supports the x86-64 levels of GCC for which the yardstick is compiled.
bool processor_has(Instructions instructions) {
  return instructions == Instructions::kAvx512 ? __builtin_cpu_supports("x86-64-v4") > 0
                                               : __builtin_cpu_supports("x86-64-v3") > 0;
}

}  // namespace

const char* instructions_name(Instructions instructions) {
  return instructions == Instructions::kAvx512 ? "AVX-512" : "AVX2";
}

Instructions choose_instructions(std::optional<Instructions> asked) {
  const Instructions chosen =
      asked.value_or(processor_has(Instructions::kAvx512) ? Instructions::kAvx512 : Instructions::kAvx2);
  if (!processor_has(chosen))
    throw Error(ErrorCode::kEnvironment,
                fmt::format("the processor has no {}, expected x86-64-v{}", instructions_name(chosen),
                            chosen == Instructions::kAvx512 ? 4 : 3));
  return chosen;
}

// PoCL keeps a separate kernel cache for each type of processor.
void limit_opencl(Instructions instructions) {
  const bool wide = instructions == Instructions::kAvx512;
  setenv("POCL_KERNELLIB_NAME", wide ? "avx512" : "avx2", 1);
  setenv("POCL_LLVM_CPU_NAME", wide ? "skylake-avx512" : "haswell", 1);
}

}  // namespace multum::bench
