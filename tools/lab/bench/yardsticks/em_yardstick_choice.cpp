// SPDX-License-Identifier: Apache-2.0
// Chooses the build of the yardstick that fits the processor.
#include "tools/lab/bench/yardsticks/em_yardstick.h"

namespace multum::bench {

std::vector<float> fit_with_yardstick_3(const YardstickLevel& level);
std::vector<float> fit_with_yardstick_4(const YardstickLevel& level);

std::vector<float> fit_with_yardstick(const YardstickLevel& level, Instructions instructions) {
  return instructions == Instructions::kAvx512 ? fit_with_yardstick_4(level) : fit_with_yardstick_3(level);
}

}  // namespace multum::bench
