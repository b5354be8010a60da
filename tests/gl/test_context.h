// SPDX-License-Identifier: Apache-2.0
// The GL contexts that tests run on: OSMesa and EGL, or the one that MULTUM_TEST_GL names (osmesa or egl), where a
// machine has only one, or where the GPU behind EGL is what is to be tested.
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

/// What two ways of filtering the same textures may differ by: Mesa's software takes the weights of texels as floats,
/// GPUs round them to 8 bits or so.
inline double filter_tolerance(const HeadlessContext& context, double of_software, double of_gpus) {
  return context.description().find("llvmpipe") != std::string::npos ? of_software : of_gpus;
}

/// A context whose driver says what it thinks of each call: its words are beside a test's failure.
inline std::unique_ptr<HeadlessContext> make_test_context(ContextBackend backend) {
  return make_headless_context(backend, DebugOutput::kOn);
}

/// For tests that one context is enough for.
inline ContextBackend test_backend() { return test_backends().front(); }

}  // namespace multum::gl
