// SPDX-License-Identifier: Apache-2.0
// Names some rows of a level.
#pragma once

namespace multum {

/// Rows [begin, end). Of a map that repeats they may lie beyond its borders.
struct LevelRows {
  int begin = 0, end = 0;
};

}  // namespace multum
