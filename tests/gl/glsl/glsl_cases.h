// SPDX-License-Identifier: Apache-2.0
// The numerical cases of runtime_gl/shaders: as those of the kernels (host/lab/selftest), by the GL that a context has.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/lab/reference/numerical_case.h"
#include "tests/gl/shader_harness.h"

namespace multum::gl {

struct GlslCase {
  NumericalCaseText text;           // its formula: a file, or some, "a.glsl, b.glsl"
  std::vector<SourceEdit> without;  // what takes the guard out: each edit one guard, tried by itself
  /// Adds errors; the shader's text is edited so.
  std::function<void(const GlFunctions& gl, const std::vector<SourceEdit>& edits, WorstError& worst)> run;
  std::vector<std::string> functions = {};  // of these files, which the case is for: broken, they break its bound
  std::vector<SourceEdit> mutation = {};    // a bug, all of these edits together; may be empty
};

const std::vector<GlslCase>& glsl_cases();

/// Values of a and b at which an expression is taken.
using GlslInputs = std::vector<std::pair<glm::vec4, glm::vec4>>;

/// The expression, a vec4 of a and b, at each of them; `variant`: flags, more formulas, uniforms and a texture.
std::vector<glm::vec4> evaluate_glsl(const GlFunctions& gl, const std::vector<SourceEdit>& edits,
                                     const std::string& expression, const GlslInputs& inputs,
                                     const ShaderHarnessInput& variant);

/// An expression against `exact` of a and b as the shader sees them.
struct GlslComparison {
  std::string expression;
  GlslInputs inputs;
  std::function<glm::dvec4(const glm::dvec4& a, const glm::dvec4& b)> exact;
  bool is_relative = false;  // to each exact value; else absolute
  ShaderHarnessInput variant = {};
};

void compare_glsl(const GlFunctions& gl, const std::vector<SourceEdit>& edits, const GlslComparison& comparison,
                  WorstError& worst);

/// A unit vector, tilted by so many degrees from +z towards an azimuth in radians.
glm::dvec3 tilted(double degrees, double azimuth = 0.3);

/// A vec4 of floats.
glm::vec4 with(const glm::dvec3& v, double w);
/// The unit vector between l and v, as multum_half_vector() has it: 0 where they point apart.
glm::dvec3 half_vector(const glm::dvec3& l, const glm::dvec3& v);
/// Between vectors that are not quite of length 1, as a shader sees them.
double angle_between(const glm::dvec3& a, const glm::dvec3& b);

/// The mean of max(n . l, 0) over a vMF of that mean direction and concentration: facets' kappa h + a lobe's kappa mu.
double highlight_cosine(const glm::dvec3& sum, const glm::dvec3& l);

/// `text` of any formula becomes `replacement`.
SourceEdit glsl_edit(const std::string& text, const std::string& replacement);
/// Lobes longer than their amplitude have a negative spread then.
SourceEdit glsl_unclamped_spread();

}  // namespace multum::gl
