// SPDX-License-Identifier: Apache-2.0
// Compares two implementations of the shading of spherical harmonics: the OpenCL code with which a bake measures its
// own error (kernels/sh_shade.cl), and the GLSL code that renders (runtime_gl/shaders/common/sh_shading.glsl). Both are
// also compared with double precision, first on hard cases, then on random distributions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/averages/spherical_harmonics.h"
#include "host/formats/opencl/device.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "host/lab/selftest/sh_launch.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/fixtures/random_values.h"
#include "tests/gl/shader_harness.h"

namespace multum {
namespace {

using testing::random_direction;

// Returns the coefficients of single directions, poles, opposite tilts and a uniform distribution. Means of some of
// these follow.
std::vector<std::vector<float>> test_sets(int order, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::vector<glm::dvec3>> normals = {
      {{0.0, 0.0, 1.0}},
      {{0.0, 0.0, -1.0}},
      {{1.0, 0.0, 0.0}},
      {glm::normalize(glm::dvec3(0.5, 0.0, 1.0)), glm::normalize(glm::dvec3(-0.5, 0.0, 1.0))},
      {{1.0, 0.0, 0.0}, {-1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}}};
  for (int i = 0; i < 20; ++i) {
    normals.emplace_back();
    for (unsigned k = 0; k <= random() % 5; ++k) normals.back().push_back(random_direction(random));
  }
  std::vector<std::vector<float>> sets;
  for (const std::vector<glm::dvec3>& directions : normals) {
    sets.emplace_back(static_cast<std::size_t>(sh_coefficient_count(order)), 0.0f);
    for (const glm::dvec3& n : directions) {
      const std::vector<double> basis = reference::sh_basis_to(order, n);
      for (std::size_t k = 0; k < basis.size(); ++k)
        sets.back()[k] += static_cast<float>(basis[k] / static_cast<double>(directions.size()));
    }
  }
  return sets;
}

std::vector<glm::vec3> directions_around(unsigned seed) {
  std::vector<glm::vec3> all = {{0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, -1.0f}, {0.6f, 0.0f, 0.8f}, {1.0f, 0.0f, 0.0f}};
  std::mt19937 random(seed);
  for (int i = 0; i < 20; ++i) all.emplace_back(random_direction(random));
  return all;
}

ZonalCoefficients zonal_of(int order, float s) {
  return s == 0.0f ? zonal_lambert(order) : zonal_blinn_phong(order, static_cast<double>(s));
}

// Returns values by [set][direction]. Coefficients and zonal coefficients are each stored in a row of a texture.
std::vector<float> shade_sh_glsl(const gl::HeadlessContext& context, int order,
                                 const std::vector<std::vector<float>>& sets, const std::vector<glm::vec3>& directions,
                                 float s) {
  const auto parts = static_cast<std::size_t>(sh_part_count(order)),
             columns = parts + static_cast<std::size_t>(order) + 1;
  const ZonalCoefficients zonal = zonal_of(order, s);
  std::vector<glm::vec4> texels(columns * sets.size(), glm::vec4(0.0f));
  for (std::size_t i = 0; i < sets.size(); ++i) {
    for (std::size_t k = 0; k < sets[i].size(); ++k) texels[i * columns + k / 4][static_cast<int>(k % 4)] = sets[i][k];
    for (std::size_t l = 0; l < zonal.size(); ++l)
      texels[i * columns + parts + l] = glm::vec4(static_cast<float>(zonal[l]));
  }
  gl::Texture map(context.functions(), "coefficients",
                  {static_cast<int>(columns), static_cast<int>(sets.size()), 1, gl::TexelFormat::kRgba32f},
                  {WrapMode::kClamp, WrapMode::kClamp, false, 1.0f});
  map.upload_level(0, &texels[0].x);
  gl::ShaderHarnessInput input{
      s == 0.0f ? "test_lambert(a.xyz, int(a.w))" : "test_facets(a.xyz, int(a.w))", {}, {}, &map};
  input.flags = gl::sh_shading_flags(order);
  input.formulas = std::string(gl::shader_common_sh_shading_glsl) +
                   "void test_fetch(int set, out vec4 parts[MULTUM_SH_PARTS]) {\n"
                   "  for (int i = 0; i < MULTUM_SH_PARTS; ++i) parts[i] = texelFetch(map, ivec2(i, set), 0);\n}\n"
                   "vec4 test_lambert(vec3 w, int set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
                   "  return vec4(multum_sh_lambert(parts, 1.0, w));\n}\n"
                   "vec4 test_facets(vec3 w, int set) {\n  vec4 parts[MULTUM_SH_PARTS];\n  test_fetch(set, parts);\n"
                   "  vec3 zonal[MULTUM_SH_ORDER + 1];\n  for (int l = 0; l <= MULTUM_SH_ORDER; ++l)\n"
                   "    zonal[l] = texelFetch(map, ivec2(MULTUM_SH_PARTS + l, set), 0).rgb;\n"
                   "  return vec4(multum_sh_facets(parts, 1.0, w, zonal), 0.0);\n}\n";
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (const glm::vec3& w : directions) {
      input.a.emplace_back(w, static_cast<float>(i));
      input.b.emplace_back(0.0f);
    }
  std::vector<float> values;
  for (const glm::vec4& value : gl::evaluate_shader(context.functions(), input)) values.push_back(value.x);
  return values;
}

class ShAgreementTest : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Orders, ShAgreementTest, ::testing::Values(1, 2, 3, 4, 8, 20),
                         [](const auto& order) { return "L" + std::to_string(order.param); });

TEST_P(ShAgreementTest, OpenclGlslAndDoubleAgree) {
  constexpr unsigned kSeed = 47;
  const int order = GetParam();
  const std::vector<std::vector<float>> sets = test_sets(order, kSeed);
  const std::vector<glm::vec3> directions = directions_around(kSeed);
  static Device device = Device::open("");
  const auto context = gl::make_headless_context(gl::ContextBackend::kOsmesa);
  for (const float s : {0.0f, 1.0f, 12.0f, 100.0f, 1e4f}) {
    const ZonalCoefficients zonal = zonal_of(order, s);
    // The largest value is that of a single direction at its peak: the sum of a_l (2l+1)/4pi.
    double peak = 0.0;
    for (std::size_t l = 0; l < zonal.size(); ++l)
      peak += std::abs(zonal[l]) * (2.0 * static_cast<double>(l) + 1.0) / (4.0 * M_PI);
    const std::vector<float> glsl = shade_sh_glsl(*context, order, sets, directions, s);
    for (std::size_t i = 0; i < sets.size(); ++i) {
      const std::vector<double> opencl = shade_sh(device, order, sets[i], 1.0f, s, directions);
      const std::vector<double> coefficients(sets[i].begin(), sets[i].end());
      for (std::size_t d = 0; d < directions.size(); ++d) {
        const double expected = std::max(0.0, reference::shade_sh(coefficients, 1.0, zonal, glm::dvec3(directions[d])));
        // The error of the basis functions is within 1e-5 of their bound (host/lab/selftest/sh_cases.cpp).
        EXPECT_NEAR(opencl[d], expected, 1e-5 * peak) << s << ", " << i << ", " << d;
        EXPECT_NEAR(static_cast<double>(glsl[i * directions.size() + d]), expected, 1e-5 * peak)
            << s << ", " << i << ", " << d;
      }
    }
  }
}

}  // namespace
}  // namespace multum
