// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/instructions.h"

#include <fmt/format.h>

#include <cstdlib>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

// Tests whether the processor supports the levels x86-64-v3 and v4, for which the yardstick is compiled. clang 16 does
// not know the names of the levels. Nor does it know those of F16C, LZCNT and MOVBE, which are also part of v3 and
// which every processor with AVX2, BMI2 and FMA has.
bool processor_has(Instructions instructions) {
  const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                      __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("fma");
  if (instructions == Instructions::kAvx2) return has_v3;
  return has_v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
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
