// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of pyramids, and those of the lookups in texture_filter.glsl.

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "host/formats/asset/pyramid/reflectance_mapping.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

ShaderHarnessInput pyramid_variant() {
  ShaderHarnessInput variant;
  variant.formulas = shader_common_pyramid_glsl;
  return variant;
}

void level_of_no_extent(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_mip_level(a.xy, b.xy), 0.0, 0.0, 0.0)", {}, {}};
  for (const float x : {0.0f, 1e-40f, 1e-20f, 1e-8f, 1.0f, 1e4f, 1e15f})
    for (const float y : {0.0f, 1e-8f, 1.0f, 1e15f}) c.inputs.push_back({{x, 0.0f, 0.0f, 0.0f}, {y, y, 0.0f, 0.0f}});
  c.variant = pyramid_variant();
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    return glm::dvec4(0.5 * std::log2(std::max({a.x * a.x, b.x * b.x + b.y * b.y, 1e-30})), 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests normals from the direction of the viewer to the opposite direction, which maps to every corner of the map.
void normals_straight_away(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_reflectance_place(a.xyz), 0.0, 0.0)", {}, {}};
  for (const double degrees : {0.0, 1e-4, 30.0, 89.999, 90.0, 90.001, 150.0, 179.0, 179.99, 179.9999, 179.999999})
    for (const double azimuth : {0.0, 0.3, 2.0, 4.0}) c.inputs.push_back({with(tilted(degrees, azimuth), 0.0), {}});
  c.inputs.push_back({{0.0f, 0.0f, -1.0f, 0.0f}, {}});
  c.inputs.push_back({{-0.0f, -0.0f, -1.0f, 0.0f}, {}});
  c.variant = pyramid_variant();
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(reflectance_place({}, glm::dvec3(a)), 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Computes the shader's footprint from two derivatives, in double precision.
glm::dvec4 exact_footprint(const glm::dvec4& a, int taps_max, double size, double bias) {
  const glm::dvec2 along_x(a.x, a.y), along_y(a.z, a.w);
  const double x = glm::length(along_x), y = glm::length(along_y), longer = std::max(x, y), shorter = std::min(x, y);
  const double ratio = shorter > 0.0 ? longer / shorter : longer > 0.0 ? 1e30 : 0.0;
  const double count = std::max(std::ceil(std::min(ratio, static_cast<double>(taps_max)) - 1e-3), 1.0);
  const glm::dvec2 step = (x > y ? along_x : along_y) / (size * count);
  const double width = count == 1.0 ? longer : std::max(shorter, longer / count * std::exp2(-0.75));
  return glm::dvec4(step, count, std::log2(std::max(width, 1e-15)) + bias);
}

ShaderHarnessInput filter_variant(int taps_max, float bias) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_TAPS " + std::to_string(taps_max)};
  variant.set_uniforms = [bias](const ShaderProgram& program) { program.set("u_level_bias", bias); };
  return variant;
}

// Returns round, long, one-dimensional and empty footprints, with ratios just below and above whole numbers.
GlslInputs footprint_inputs() {
  GlslInputs inputs;
  for (const float x : {0.0f, 1e-12f, 0.25f, 1.0f, 3.0f, 1e4f})
    for (const float ratio : {0.0f, 0.05f, 0.3333333f, 0.5f, 0.52f, 1.0f}) {
      inputs.push_back({{x, 0.0f, 0.0f, ratio * x}, {}});
      inputs.push_back({{0.6f * ratio * x, 0.8f * ratio * x, -0.8f * x, 0.6f * x}, {}});
    }
  return inputs;
}

void footprints_of_no_width(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr float kSize = 64.0f, kBias = -0.5f;
  for (const int taps_max : {1, 4, 16}) {
    GlslComparison c{"test_footprint(a)", footprint_inputs(), {}};
    c.variant = filter_variant(taps_max, kBias);
    c.variant.formulas =
        "vec4 test_footprint(vec4 a) {\n  MultumFootprint f = multum_footprint_of(a.xy, a.zw, vec2(64.0));\n"
        "  return vec4(f.tap_step, float(f.tap_count), f.level);\n}\n";
    c.exact = [=](const glm::dvec4& a, const glm::dvec4&) {
      return exact_footprint(a, taps_max, static_cast<double>(kSize), static_cast<double>(kBias));
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Compares only the longer side of the footprint, with one tap and with all taps.
void longer_lengths(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr float kBias = -0.5f;
  for (const int taps_max : {1, 4, 16}) {
    GlslComparison c{"vec4(test_longer(a))", footprint_inputs(), {}};
    c.variant = filter_variant(taps_max, kBias);
    c.variant.formulas =
        "float test_longer(vec4 a) {\n"
        "  return multum_footprint_longer_lod(multum_footprint_of(a.xy, a.zw, vec2(64.0)), ivec2(64));\n}\n";
    c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
      const double longer = std::max(glm::length(glm::dvec2(a.x, a.y)), glm::length(glm::dvec2(a.z, a.w)));
      return glm::dvec4(std::log2(std::max(longer, 1e-15)) + static_cast<double>(kBias));
    };
    compare_glsl(gl, edits, c, worst);
  }
}

// Tests footprints that were computed for a texture of another size.
void footprints_on_another_size(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"test_other(a)", {}, {}};
  for (const float from : {1.0f, 37.0f, 64.0f, 4096.0f})
    for (const float to : {1.0f, 16.0f, 148.0f, 4096.0f}) c.inputs.push_back({{from, to, 1.5f, 0.0f}, {}});
  c.variant = filter_variant(4, 0.0f);
  c.variant.formulas =
      "vec4 test_other(vec4 a) {\n  MultumFootprint f = multum_footprint_on(MultumFootprint(vec2(0.1, 0.2), 3, a.z),\n"
      "      ivec2(int(a.x), 1), ivec2(1, int(a.y)));\n"
      "  return vec4(f.tap_step, float(f.tap_count), f.level);\n}\n";
  c.exact = [](const glm::dvec4& a, const glm::dvec4&) {
    return glm::dvec4(static_cast<double>(0.1f), static_cast<double>(0.2f), 3.0, a.z + std::log2(a.y / a.x));
  };
  compare_glsl(gl, edits, c, worst);
}

// Returns the number of columns and rows of the grid. Divides the longer side into halves again and again, as long as
// the parts are longer than wide.
glm::dvec2 exact_grid(double count, double along_x, double along_y) {
  const double ratio = std::max(along_x, along_y) / std::max(std::min(along_x, along_y), 1e-20);
  double across = 1.0;
  while (ratio * 2.0 * across * across < count && across * across * 4.0 <= count) across *= 2.0;
  return along_x > along_y ? glm::dvec2(count / across, across) : glm::dvec2(across, count / across);
}

// Tests round, long and one-dimensional footprints with every number of points.
void points_of_no_width(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison grids{
      "vec4(multum_point_grid(a.z, a.x, a.y), multum_lobe_points(a.z, a.w), "
      "multum_widened_alpha(0.25, vec3(b.x), vec3(0.0, b.y, 0.0), a.z))",
      {},
      {}};
  GlslComparison places{"vec4(multum_point_place(a.x, b.xy), 0.0, 0.0)", {}, {}};
  for (const float count : {1.0f, 2.0f, 4.0f, 8.0f, 16.0f})
    for (const float x : {0.0f, 0.5f, 1.0f, 1.5f, 9.0f, 1e4f})
      for (const float y : {0.0f, 1.0f, 3.0f}) {
        grids.inputs.push_back({{x, y, count, 1.0f + y}, {0.1f * x, y, 0.0f, 0.0f}});
        const glm::dvec2 grid = exact_grid(static_cast<double>(count), static_cast<double>(x), static_cast<double>(y));
        for (float point = 0.0f; point < count; point += 1.0f)
          places.inputs.push_back({{point, 0.0f, 0.0f, 0.0f}, glm::vec4(glm::vec2(grid), 0.0f, 0.0f)});
      }
  grids.variant.formulas = places.variant.formulas = shader_common_evaluations_glsl;
  grids.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    double points = 1.0;
    while (2.0 * points * a.w <= a.z) points *= 2.0;
    const double variance = (3.0 * b.x * b.x + b.y * b.y) / (12.0 * a.z);
    return glm::dvec4(exact_grid(a.z, a.x, a.y), points, std::sqrt(std::min(0.0625 + variance, 1.0)));
  };
  places.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double row = std::floor(a.x / b.x), column = a.x - row * b.x;
    return glm::dvec4((column + 0.5) / b.x - 0.5, (row + 0.5) / b.y - 0.5, 0.0, 0.0);
  };
  compare_glsl(gl, edits, grids, worst);
  compare_glsl(gl, edits, places, worst);
}

}  // namespace

std::vector<GlslCase> glsl_filter_cases() {
  const std::string file = "texture_filter.glsl";
  return {
      {{"glsl-level-of-no-extent", "pyramid.glsl",
        "if texture coordinates do not change between pixels, the mip level is the logarithm of 0",
        "the squared length is at least 1e-30", 1e-4, "absolute error of the level",
        "the GL's log2 function is not exact"},
       {glsl_edit("max(max(dot(along_x, along_x), dot(along_y, along_y)), 1e-30)",
                  "max(dot(along_x, along_x), dot(along_y, along_y))")},
       level_of_no_extent,
       {"multum_mip_level"}},
      {{"glsl-normals-straight-away", "pyramid.glsl",
        "for normals that face away, 1 + z loses digits by cancellation, and the projection of (0, 0, -1) is 0 divided "
        "by 0",
        "the length of the projection is computed from 1 - z, and the normal (0, 0, -1) maps to a corner", 1e-4,
        "absolute error of s and t",
        "the z of a normal has a rounding error of up to 6e-8, and the shader rounds a few more times"},
       {glsl_edit("if (n.z > 0.0) return", "if (true) return")},
       normals_straight_away,
       {"multum_reflectance_place"}},
      {{"glsl-footprints-of-no-width", file, "a footprint of length 0 causes a division by 0 and a logarithm of 0",
        "lengths are at least 1e-15", 2e-4, "absolute error of steps, taps and levels",
        "the logarithms of lengths down to 1e-15 are large in magnitude, so they are rounded more coarsely"},
       {glsl_edit("log2(max(width, 1e-15))", "log2(width)")},
       footprints_of_no_width,
       {"multum_footprint_of"}},
      {{"glsl-footprints-on-another-size", file,
        "the shader uses a level that was computed for a texture of another size",
        "the shader adds to the level the log2 of the ratio between the longer sides of both textures", 1e-4,
        "absolute error of the level", "the GL's log2 function is not exact"},
       {glsl_edit("footprint.level + octaves", "footprint.level")},
       footprints_on_another_size,
       {"multum_footprint_on"}},
      {{"glsl-longer-lengths-of-footprints", file,
        "a footprint of one tap has a step of 0, and the logarithm of 0 is infinite",
        "for one tap, the shader returns the level of this tap", 2e-4, "absolute error of the level",
        "the logarithms of lengths down to 1e-15 are large in magnitude, so they are rounded more coarsely"},
       {glsl_edit("if (footprint.tap_count == 1) return footprint.level;", "")},
       longer_lengths,
       {"multum_footprint_longer_lod"}},
      {{"glsl-points-of-no-width", "evaluations.glsl",
        "the shader divides by a length of 0, which gives infinity or NaN", "lengths are at least 1e-20", 1e-4,
        "absolute error of points, positions and alpha", "only a few operations are rounded"},
       {glsl_edit("max(min(along_x, along_y), 1e-20)", "min(along_x, along_y)")},
       points_of_no_width,
       {"multum_lobe_points", "multum_point_grid", "multum_point_place", "multum_geometry_variance",
        "multum_widened_alpha"}},
  };
}

}  // namespace multum::gl
