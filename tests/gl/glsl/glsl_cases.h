// SPDX-License-Identifier: Apache-2.0
// Declares the numerical cases of runtime_gl/shaders. These cases are like the cases of the kernels
// (host/lab/selftest), but they run in a GL context.
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
  NumericalCaseText text;           // names the files of the formula, such as "a.glsl, b.glsl"
  std::vector<SourceEdit> without;  // edits that remove a guard; each is tried separately
  /// Runs the case with the edited shader and adds its errors.
  std::function<void(const GlFunctions& gl, const std::vector<SourceEdit>& edits, WorstError& worst)> run;
  std::vector<std::string> functions = {};  // functions that the case tests; if one of them is broken, the case exceeds
                                            // its bound
  std::vector<SourceEdit> mutation = {};    // edits that together plant a bug; may be empty
};

const std::vector<GlslCase>& glsl_cases();

/// Holds the values of a and b for which an expression is evaluated.
using GlslInputs = std::vector<std::pair<glm::vec4, glm::vec4>>;

/// Evaluates the expression, which is a vec4 that depends on a and b, for each input. `variant` adds flags, formulas,
/// uniforms and a texture.
std::vector<glm::vec4> evaluate_glsl(const GlFunctions& gl, const std::vector<SourceEdit>& edits,
                                     const std::string& expression, const GlslInputs& inputs,
                                     const ShaderHarnessInput& variant);

/// Compares an expression with `exact`, which gets the same values of a and b as the shader.
struct GlslComparison {
  std::string expression;
  GlslInputs inputs;
  std::function<glm::dvec4(const glm::dvec4& a, const glm::dvec4& b)> exact;
  bool is_relative = false;  // if true, errors are relative to each exact value; otherwise they are absolute
  ShaderHarnessInput variant = {};
};

void compare_glsl(const GlFunctions& gl, const std::vector<SourceEdit>& edits, const GlslComparison& comparison,
                  WorstError& worst);

/// Returns a unit vector that is tilted from +z by `degrees` towards the azimuth (in radians).
glm::dvec3 tilted(double degrees, double azimuth = 0.3);

/// Returns a vec4 of floats.
glm::vec4 with(const glm::dvec3& v, double w);
/// Returns the unit vector between l and v, like multum_half_vector(). The result is 0 if l and v are opposite.
glm::dvec3 half_vector(const glm::dvec3& l, const glm::dvec3& v);
/// Returns the angle between two vectors as a shader sees them, with lengths that are not exactly 1.
double angle_between(const glm::dvec3& a, const glm::dvec3& b);

/// Returns the mean of max(n . l, 0) over the vMF for which kappa * axis equals `sum`. `sum` is h times the kappa of
/// the facets plus mu times the kappa of the lobe.
double highlight_cosine(const glm::dvec3& sum, const glm::dvec3& l);

/// Replaces `text` in any formula.
SourceEdit glsl_edit(const std::string& text, const std::string& replacement);
/// Removes the clamp of the spread. Lobes that are longer than their amplitude then have a negative spread.
SourceEdit glsl_unclamped_spread();

}  // namespace multum::gl
