// SPDX-License-Identifier: Apache-2.0
// Lists the GL contexts that tests run on: OSMesa and EGL, or only the one that MULTUM_TEST_GL names (osmesa or egl).
// Set the variable if the machine has only one of them, or to test the GPU that EGL uses.
#pragma once

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "runtime_gl/context/headless_context.h"

namespace multum::gl {

inline std::vector<ContextBackend> test_backends() {
  const char* const named = std::getenv("MULTUM_TEST_GL");
  const auto wanted = named != nullptr ? find_choice(kContextBackends, named) : std::nullopt;
  if (wanted && *wanted != ContextBackend::kAuto) return {*wanted};
  return {ContextBackend::kOsmesa, ContextBackend::kEgl};
}

/// The largest difference between two ways of filtering the same textures. Mesa's software renderer stores the weights
/// of texels as floats, whereas GPUs round them to about 8 bits.
inline double filter_tolerance(const HeadlessContext& context, double of_software, double of_gpus) {
  return context.description().find("llvmpipe") != std::string::npos ? of_software : of_gpus;
}

/// Makes a context whose driver reports messages about each call. The messages appear next to the failure of a test.
inline std::unique_ptr<HeadlessContext> make_test_context(ContextBackend backend) {
  return make_headless_context(backend, DebugOutput::kOn);
}

/// Returns the back-end for tests that need only one context.
inline ContextBackend test_backend() { return test_backends().front(); }

}  // namespace multum::gl
