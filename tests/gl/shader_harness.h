// SPDX-License-Identifier: Apache-2.0
// Evaluates a GLSL expression over arrays: one fragment an element, inputs and outputs in RGBA32F, read back exactly.
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
  std::string expression;               // a vec4, of the vec4s a and b, with the functions of common/ and brdf/
  std::vector<glm::vec4> a;             // at most 16384 elements
  std::vector<glm::vec4> b;             // as many
  const Texture* texture = nullptr;     // bound to the sampler `map`
  std::vector<SourceEdit> edits = {};   // of kGlslFormulas: what takes a guard out
  std::vector<std::string> flags = {};  // #define lines
  std::string formulas = {};            // more of the shaders, which may read `map`
  std::function<void(const ShaderProgram& program)> set_uniforms = {};  // and textures, from unit 3 on
};

/// What edits call the text of all formulas together.
constexpr char kGlslFormulas[] = "formulas";

/// The output is poisoned with NaN first: an element that no fragment wrote shows.
std::vector<glm::vec4> evaluate_shader(const GlFunctions& gl, const ShaderHarnessInput& input);

}  // namespace multum::gl
