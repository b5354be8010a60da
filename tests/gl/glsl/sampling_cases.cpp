// SPDX-License-Identifier: Apache-2.0
// Defines the numerical cases of random samples: normals of lobes, values of blue noise, and texels of footprints.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "host/lab/reference/shading.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/shaders/embedded_shaders.h"
#include "tests/gl/glsl/case_lists.h"

namespace multum::gl {
namespace {

using Edits = std::vector<SourceEdit>;

// Tests lobes of every width in every direction. For lobes that point downwards, the shader chooses different tangents.
void normals_drawn(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(multum_movmf_drawn_normal(a, b.xy), 0.0)", {}, {}};
  for (const double tilt : {0.0, 40.0, 90.0, 140.0, 180.0})
    for (const float spread : {-1e-4f, 0.0f, 1e-6f, 0.1f, 0.9f, 1.0f})
      for (const float x : {0.0f, 0.3f, 0.9f, 0.9999999f, 1.0f})
        for (const float y : {0.0f, 0.4f})
          c.inputs.push_back({with(static_cast<double>(1.0f - spread) * tilted(tilt), 1.0), {x, y, 0.0f, 0.0f}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double size = glm::length(glm::dvec3(a)), d = std::clamp(1.0 - size, 0.0, 1.0);
    const glm::dvec3 mu = size > 1e-12 ? glm::dvec3(a) / size : glm::dvec3(0.0, 0.0, 1.0);
    const double kappa = d <= 0.0 ? 1e12 : d >= 1.0 ? 1e-3 : std::max(reference::vmf_kappa(d), 1e-3);
    const double e = std::clamp(-std::log(std::max(1.0 - b.x * -std::expm1(-2.0 * kappa), 1e-30)) / kappa, 0.0, 2.0);
    const double side = mu.z < 0.0 ? -1.0 : 1.0, q = -1.0 / (side + mu.z), r = mu.x * mu.y * q;
    const glm::dvec3 s(1.0 + side * mu.x * mu.x * q, side * r, -side * mu.x), t(r, side + mu.y * mu.y * q, -mu.y);
    const double phi = 2.0 * M_PI * b.y;
    return glm::dvec4((1.0 - e) * mu + std::sqrt(e * (2.0 - e)) * (std::cos(phi) * s + std::sin(phi) * t), 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

// Tests a pixel in many frames. Some frame numbers are so large that their product has no fractional part in single
// precision. `map` contains quarters.
void numbers_of_the_millionth_frame(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kSide = 64;
  std::vector<float> texels;
  for (int i = 0; i < kSide * kSide; ++i)
    for (int c = 0; c < 4; ++c) texels.push_back(0.25f * static_cast<float>((i + i / kSide + c) % 4));
  Texture noise(gl, "noise", {kSide, kSide, 1, TexelFormat::kRgba32f},
                {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  noise.upload_level(0, texels.data());
  GlslComparison c{"vec4(multum_blue_noise(map, a.xy, b.x), 0.0)", {}, {}};
  for (const float x : {0.0f, 0.5f, 63.9f, 64.0f, 1919.5f})
    for (const float y : {0.5f, 70.0f, 1079.5f})
      for (const float frame : {0.0f, 1.0f, 1023.0f, 1024.0f, 1030.0f, 1000003.0f, 16777215.0f})
        c.inputs.push_back({{x, y, 0.0f, 0.0f}, {frame, 0.0f, 0.0f, 0.0f}});
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const double steps[] = {0.618033988749895, 0.754877666246693, 0.569840290998053}, count = std::fmod(b.x, 1024.0);
    const int column = static_cast<int>(a.x) % kSide, row = static_cast<int>(a.y) % kSide;
    glm::dvec4 numbers(0.0);
    for (int k = 0; k < 3; ++k) {
      const double texel = 0.25 * ((row * kSide + column + row + k) % 4);
      const double place = texel * 255.0 / 256.0 + count * steps[k];
      numbers[k] = place - std::floor(place);
    }
    return numbers;
  };
  c.variant.texture = &noise;
  c.variant.formulas = shader_common_blue_noise_glsl;
  compare_glsl(gl, edits, c, worst);
}

int wrapped(int i, int size, int mode) {
  if (mode == 1) return std::clamp(i, 0, size - 1);
  if (mode == 0) return i >= 0 && i < size ? i : -1;
  const int period = mode == 2 ? size : 2 * size, at = ((i % period) + period) % period;
  return at < size ? at : period - 1 - at;
}

ShaderHarnessInput footprint_variant(int sample, int wrap) {
  ShaderHarnessInput variant;
  variant.flags = {"MULTUM_REFERENCE"};
  variant.formulas = shader_common_footprint_glsl;
  variant.set_uniforms = [=](const ShaderProgram& program) {
    program.set("u_sample", sample);
    program.set("u_wrap_s", wrap);
    program.set("u_wrap_t", wrap);
  };
  return variant;
}

void texels_far_outside(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  GlslComparison c{"vec4(float(multum_wrapped(int(a.x), int(b.x), int(b.y))), 0.0, 0.0, 0.0)", {}, {}};
  for (const int size : {1, 2, 3, 37, 4096})
    for (const int mode : {0, 1, 2, 3})
      for (const int i :
           {0, 1, -1, size - 1, size, -size, -size - 1, 2 * size, 2 * size - 1, -2 * size, 8388607, -8388607})
        c.inputs.push_back(
            {glm::vec4(static_cast<float>(i)), {static_cast<float>(size), static_cast<float>(mode), 0.0f, 0.0f}});
  c.variant = footprint_variant(0, 0);
  c.exact = [](const glm::dvec4& a, const glm::dvec4& b) {
    const int texel = wrapped(static_cast<int>(a.x), static_cast<int>(b.x), static_cast<int>(b.y));
    return glm::dvec4(texel, 0.0, 0.0, 0.0);
  };
  compare_glsl(gl, edits, c, worst);
}

std::uint32_t hash(std::uint32_t v) {
  const std::uint32_t state = v * 747796405u + 2891336453u;
  const std::uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return (word >> 22u) ^ word;
}

// Uses the index of each element as its pixel number.
void places_of_the_billionth_sample(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr std::uint32_t kSteps[] = {3859688306u, 3468523225u, 3117001274u, 2801104767u, 2517223198u, 2262111973u};
  for (const int sample : {0, 1, 1000003, 2147483647}) {
    GlslInputs inputs;
    for (std::uint32_t i = 0; i < 100; ++i) inputs.emplace_back(glm::vec4(), glm::vec4(static_cast<float>(i % 6)));
    const std::vector<glm::vec4> found =
        evaluate_glsl(gl, edits, "vec4(multum_random(int(b.x)), 0.0, 0.0, 0.0)", inputs, footprint_variant(sample, 0));
    for (std::uint32_t i = 0; i < 100; ++i) {
      const std::uint32_t n = i % 6, place = hash(i + hash(hash(n))) + static_cast<std::uint32_t>(sample) * kSteps[n];
      worst.add(static_cast<double>(found[i].x), static_cast<double>(place >> 8u) / 16777216.0, 1.0,
                fmt::format("sample {}, coordinate {}", sample, n));
    }
  }
}

// Tests that the shader chooses only texels that a filter would mix at this position. The positions are inside the map
// and far outside.
void footprints_of_one_place(const GlFunctions& gl, const Edits& edits, WorstError& worst) {
  constexpr int kWidth = 37, kHeight = 21;
  constexpr WrapMode kModes[] = {WrapMode::kBlack, WrapMode::kClamp, WrapMode::kPeriodic, WrapMode::kMirror};
  for (const int mode : {0, 1, 2, 3})
    for (const glm::vec2& st : {glm::vec2(0.0f, 0.999999f), glm::vec2(-3.3f, 17.25f)}) {
      const Texture map(gl, "map", {kWidth, kHeight}, {kModes[mode], kModes[mode], true, 1.0f});
      ShaderHarnessInput variant = footprint_variant(7, mode);
      variant.texture = &map;
      variant.formulas += "uniform vec2 u_place;\n";
      variant.set_uniforms = [&st, set = variant.set_uniforms](const ShaderProgram& program) {
        set(program);
        program.set_vec2("u_place", &st.x);
      };
      for (const glm::vec4& found : evaluate_glsl(
               gl, edits,
               "vec4(vec2(multum_footprint_texel(map, u_place, MultumFootprint(vec2(0.0), 1, 0.0))), 0.0, 0.0)",
               GlslInputs(64), variant)) {
        bool is_one = false;
        for (int corner = 0; corner < 4; ++corner) {
          const glm::vec2 place = st * glm::vec2(kWidth, kHeight) - 0.5f;
          const int x = wrapped(static_cast<int>(std::floor(place.x)) + corner % 2, kWidth, mode),
                    y = wrapped(static_cast<int>(std::floor(place.y)) + corner / 2, kHeight, mode);
          const glm::vec2 texel = x < 0 || y < 0 ? glm::vec2(-1.0f) : glm::vec2(x, y);
          is_one = is_one || texel == glm::vec2(found);
        }
        worst.add(is_one ? 0.0 : 1.0,
                  fmt::format("mode {}, ({}, {}): texel ({}, {})", mode, st.x, st.y, found.x, found.y));
      }
    }
}

}  // namespace

std::vector<GlslCase> glsl_sampling_cases() {
  return {
      {{"glsl-normals-drawn-from-any-lobe", "movmf_shading.glsl",
        "rounding gives a random normal a cosine below -1, and the square root of a negative number is NaN",
        "1 - cosine is clamped to the range 0 to 2", 3e-2, "absolute error of a unit vector",
        "for a lobe that fills the sphere, the logarithm of a number near 1 is divided by a small kappa, which "
        "magnifies its rounding error"},
       {glsl_edit("clamp(-log(max(1.0 - xi.x * (1.0 - exp(-2.0 * kappa)), 1e-30)) / kappa, 0.0, 2.0)",
                  "(-log(max(1.0 - xi.x * (1.0 - exp(-2.0 * kappa)), 1e-30)) / kappa)")},
       normals_drawn,
       {"multum_movmf_drawn_normal"}},
      {{"glsl-numbers-of-the-millionth-frame", "blue_noise.glsl",
        "a large product has no fractional digits in float, so all frames use the same random number",
        "the shader reduces frame numbers modulo 1024", 1e-4, "absolute error",
        "the largest product is 772, which has a rounding error of up to 6e-5"},
       {glsl_edit("frame - MULTUM_BLUE_NOISE_FRAMES * floor(frame / MULTUM_BLUE_NOISE_FRAMES)", "frame")},
       numbers_of_the_millionth_frame,
       {"multum_blue_noise"}},
      {{"glsl-texels-far-outside", "footprint.glsl",
        "quotients that are truncated towards 0 select wrong texels to the left of the map",
        "quotients are rounded down", kNothingWrong, "texels of difference",
        "texel coordinates are whole numbers and must be exact"},
       {glsl_edit("(i >= 0 ? i / period : -1 - (-1 - i) / period)", "(i / period)")},
       texels_far_outside,
       {"multum_wrapped"}},
      {{"glsl-places-of-the-billionth-sample", "footprint.glsl",
        "a large product has no fractional digits in float, so all samples have the same position",
        "integer products wrap modulo 2^32", kNothingWrong, "absolute error", "every bit must be equal"},
       {glsl_edit("float((pixel + uint(u_sample) * steps[n]) >> 8u) / 16777216.0",
                  "fract(float(pixel) / 4294967296.0 + float(u_sample) * (float(steps[n]) / 4294967296.0))")},
       places_of_the_billionth_sample,
       {"multum_hash", "multum_random"}},
      {{"glsl-footprints-of-one-place", "footprint.glsl", "the shader reads a texel beyond a black border",
        "the shader does not read texels beyond a black border", kNothingWrong, "wrong texels",
        "no wrong texel is allowed"},
       {glsl_edit("if (min(texel.x, texel.y) < 0) return MULTUM_NO_TEXEL;", "")},
       footprints_of_one_place,
       {"multum_footprint_texel"}},
  };
}

}  // namespace multum::gl
