// SPDX-License-Identifier: Apache-2.0
// Which build of the yardstick runs: that for AVX-512 where the processor has it, else that for AVX2.
#include "host/base/error.h"
#include "tools/bench/yardsticks/em_yardstick.h"

namespace multum::bench {

std::vector<float> fit_with_yardstick_3(const YardstickLevel& level);
std::vector<float> fit_with_yardstick_4(const YardstickLevel& level);

std::vector<float> fit_with_yardstick(const YardstickLevel& level) {
  if (__builtin_cpu_supports("x86-64-v4")) return fit_with_yardstick_4(level);
  if (__builtin_cpu_supports("x86-64-v3")) return fit_with_yardstick_3(level);
  throw Error(ErrorCode::kEnvironment, "the yardstick of EM needs a processor with AVX2 (x86-64-v3)");
}

}  // namespace multum::bench
