// SPDX-License-Identifier: Apache-2.0
// The numerical cases of runtime_gl/shaders/common/movmf_shading.glsl: as those of the kernels (host/selftest), by the
// GL that a context has.
#pragma once

#include <functional>
#include <vector>

#include "host/reference/numerical_case.h"
#include "tests/gl/shader_harness.h"

namespace multum::gl {

struct GlslCase {
  NumericalCaseText text;
  std::vector<SourceEdit> without;  // what takes the guard out
  /// Adds errors; the shader's text is edited so.
  std::function<void(const GlFunctions& gl, const std::vector<SourceEdit>& edits, WorstError& worst)> run;
};

const std::vector<GlslCase>& glsl_cases();

}  // namespace multum::gl
