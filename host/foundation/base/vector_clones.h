// SPDX-License-Identifier: Apache-2.0
// Compiles loops once for every width of vector registers. The program uses the widest registers of the machine. All
// widths give the same bits, for two reasons: such a loop computes each element independently, and no multiplication is
// contracted with an addition (-ffp-contract=off, for every target).
#pragma once

#include <cstddef>
#include <vector>

// The loader chooses the clone before sanitizers are initialized, so programs with sanitizers use the plain loop.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define MULTUM_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define MULTUM_VECTOR_CLONES
#endif

namespace multum {

/// An array of doubles that begins at a cache line. The widest registers have the size of one line, and an access that
/// crosses two lines is slow.
class AlignedRow {
 public:
  explicit AlignedRow(std::size_t count = 0) : lines_((count + 7) / 8) {}
  double* data() { return reinterpret_cast<double*>(lines_.data()); }
  bool empty() const { return lines_.empty(); }

 private:
  struct alignas(64) Line {
    double values[8];
  };
  std::vector<Line> lines_;
};

}  // namespace multum
