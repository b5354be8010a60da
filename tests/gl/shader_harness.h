// SPDX-License-Identifier: Apache-2.0
// Evaluates a GLSL expression over arrays, with one fragment per element. Inputs and outputs are RGBA32F and are read
// back exactly.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <glm/vec4.hpp>

#include "host/foundation/base/source_edit.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

struct ShaderHarnessInput {
  std::string expression;               // a vec4 expression in the vec4s a and b, which may call functions of common/
                                        // and brdf/
  std::vector<glm::vec4> a;             // at most 16384 elements
  std::vector<glm::vec4> b;             // as many elements as `a`
  const Texture* texture = nullptr;     // bound to the sampler `map`
  std::vector<SourceEdit> edits = {};   // edits to kGlslFormulas that remove a guard
  std::vector<std::string> flags = {};  // #define lines
  std::string formulas = {};            // more shader text, which may read `map`
  std::function<void(const ShaderProgram& program)> set_uniforms = {};  // also binds textures, from unit 3 on
};

/// This name refers to the text of all formulas in edits.
constexpr char kGlslFormulas[] = "formulas";

/// Evaluates the expression. The output is poisoned with NaN first, so that an element without a fragment is noticed.
std::vector<glm::vec4> evaluate_shader(const GlFunctions& gl, const ShaderHarnessInput& input);

}  // namespace multum::gl
