// SPDX-License-Identifier: Apache-2.0
// Workaround "ISA-L leaves vector registers in use": the AVX functions of ISA-L 2.30 return without VZEROUPPER.
// Afterwards, every SSE instruction of the thread waits, because it preserves the unneeded upper halves of the
// registers. As a result, rounding took twice as long after a checksum. Call this function after each call of such a
// function.
#pragma once

namespace multum {

#if defined(__x86_64__)
__attribute__((target("avx"))) inline void zero_upper_halves() { __builtin_ia32_vzeroupper(); }
inline void leave_vector_registers() {
  static const bool has_avx = __builtin_cpu_supports("avx") != 0;
  if (has_avx) zero_upper_halves();
}
#else
inline void leave_vector_registers() {}
#endif

}  // namespace multum
