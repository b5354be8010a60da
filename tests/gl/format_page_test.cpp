// SPDX-License-Identifier: Apache-2.0
// Tests the shader of docs/reference/file_format.md, "In GLSL", exactly as printed. The test pastes the code as the
// page says, and a driver compiles it as the GLSL version that the page names. One pixel is compared with the integral
// over normals.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <regex>

#include "host/lab/reference/shading.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/gl/texture.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

std::string source_file(const std::string& name) {
  std::ifstream file(std::string(MULTUM_SOURCE_DIR) + "/" + name, std::ios::binary);
  EXPECT_TRUE(file.good()) << name;
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Returns the text from this heading to the next heading.
std::string section(const std::string& heading) {
  const std::string page = source_file("docs/reference/file_format.md");
  const std::size_t begin = page.find("\n### " + heading + "\n");
  if (begin == std::string::npos) return "";
  return page.substr(begin + 1, page.find("\n### ", begin + 1) - begin);
}

/// Joins all code of the numbered list in order. `is_es` selects the version line for OpenGL ES.
std::string pasted(bool is_es) {
  const std::string text = section("In GLSL");
  const std::regex item("\n([1-4])\\. ([^\n]*)"), code("`([^`]+)`");
  std::string result;
  for (std::sregex_iterator line(text.begin(), text.end(), item), end; line != end; ++line) {
    const std::string words = (*line)[2];
    std::vector<std::string> codes;
    for (std::sregex_iterator one(words.begin(), words.end(), code); one != end; ++one) codes.push_back((*one)[1]);
    if ((*line)[1] == "1") {
      if (!is_es) codes.resize(1);
      else codes.erase(codes.begin());
      for (const std::string& one : codes) result += one + "\n";
    } else if ((*line)[1] != "4") {
      result += source_file(codes.at(0));
    }
  }
  const std::size_t begin = text.find("```glsl\n") + 8;
  return result + text.substr(begin, text.find("```", begin) - begin);
}

GLuint compiled(const GlFunctions& gl, GLenum stage, const std::string& text) {
  const GLuint shader = gl.CreateShader(stage);
  const char* const source = text.c_str();
  gl.ShaderSource(shader, 1, &source, nullptr);
  gl.CompileShader(shader);
  GLint is_compiled = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &is_compiled);
  std::array<char, 4096> log = {};
  gl.GetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
  EXPECT_EQ(is_compiled, GL_TRUE) << log.data() << "\n" << text;
  return shader;
}

/// Links the pasted fragment shader with a triangle that covers the picture with one `uv`.
GLuint linked(const GlFunctions& gl, bool is_es) {
  const std::string version = is_es ? "#version 300 es\n" : "#version 330 core\n";
  const GLuint vertex = compiled(gl, GL_VERTEX_SHADER,
                                 version +
                                     "out vec2 uv;\nvoid main() {\n  uv = vec2(0.5);\n"
                                     "  vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));\n"
                                     "  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);\n}\n");
  const GLuint fragment = compiled(gl, GL_FRAGMENT_SHADER, pasted(is_es));
  const GLuint program = gl.CreateProgram();
  gl.AttachShader(program, vertex);
  gl.AttachShader(program, fragment);
  gl.LinkProgram(program);
  gl.DeleteShader(vertex);
  gl.DeleteShader(fragment);
  GLint is_linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &is_linked);
  EXPECT_EQ(is_linked, GL_TRUE);
  return program;
}

// The drawn map has two texels of two lobes each, and the pixel is midway between them.
struct Lobe {
  glm::dvec3 mean;  // a r
  double amplitude;
};
const glm::dvec3 kLight = glm::normalize(glm::dvec3(0.3, 0.5, 0.8)), kEye = glm::normalize(glm::dvec3(-0.4, 0.1, 0.9));
const glm::dvec3 kIrradiance(3.0, 2.0, 1.0), kAlbedo(0.8, 0.4, 0.2), kHighlight(0.05, 0.1, 0.2);
constexpr double kExponent = 40.0;
const std::array<std::array<Lobe, 2>, 2> kLobes = {  // indexed by texel and lobe
    {{{{0.70 * 0.95 * glm::normalize(glm::dvec3(0.1, 0.3, 1.0)), 0.7},
       {0.30 * 0.60 * glm::normalize(glm::dvec3(-0.6, 0.1, 0.8)), 0.3}}},
     {{{0.50 * 0.98 * glm::normalize(glm::dvec3(0.0, 0.2, 1.0)), 0.5},
       {0.50 * 0.80 * glm::normalize(glm::dvec3(-0.4, 0.3, 0.8)), 0.5}}}}};

glm::dvec3 expected_colour() {
  const glm::dvec3 half = glm::normalize(kLight + kEye);
  glm::dvec3 sum(0.0);
  for (std::size_t j = 0; j < 2; ++j) {
    const glm::dvec3 mean = 0.5 * (kLobes[0][j].mean + kLobes[1][j].mean);
    const double amplitude = 0.5 * (kLobes[0][j].amplitude + kLobes[1][j].amplitude);
    const double kappa = reference::vmf_kappa(1.0 - glm::length(mean) / amplitude);
    const glm::dvec3 mu = glm::normalize(mean);
    const double diffuse = reference::convolved_lambert(kappa, std::acos(glm::dot(mu, kLight)));
    const double highlight = reference::highlight([](double theta) { return reference::blinn_phong(kExponent, theta); },
                                                  kExponent, kappa, mu, half, kLight)
                                 .with_cosine;
    sum += amplitude * (diffuse * kAlbedo / std::numbers::pi + highlight * kHighlight);
  }
  return kIrradiance * sum;
}

Texture lobe_map(const GlFunctions& gl) {
  Texture map(gl, "lobe_map", {2, 1, 1, TexelFormat::kRgba16Snorm, 2},
              {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  for (std::size_t j = 0; j < 2; ++j) {
    std::array<float, 8> texels = {};
    for (std::size_t x = 0; x < 2; ++x)
      for (std::size_t c = 0; c < 4; ++c)
        texels[4 * x + c] =
            static_cast<float>(c < 3 ? kLobes[x][j].mean[static_cast<glm::length_t>(c)] : kLobes[x][j].amplitude);
    map.upload_layer(0, static_cast<int>(j), texels.data());
  }
  return map;
}

void set_uniforms(const GlFunctions& gl, GLuint program) {
  const auto vector = [&](const char* name, const glm::dvec3& value) {
    const glm::vec3 floats(value);
    const GLint at = gl.GetUniformLocation(program, name);
    EXPECT_GE(at, 0) << name;
    gl.ProgramUniform3fv(program, at, 1, &floats.x);
  };
  vector("l", kLight);
  vector("v", kEye);
  vector("light", kIrradiance);
  vector("albedo", kAlbedo);
  vector("k_s", kHighlight);
  gl.ProgramUniform1f(program, gl.GetUniformLocation(program, "s"), static_cast<float>(kExponent));
  gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "lobe_count"), 2);
  gl.ProgramUniform1i(program, gl.GetUniformLocation(program, "lobe_map"), 0);
}

TEST(FormatPage, ItsShaderShadesAsTheIntegralDoes) {
  ASSERT_FALSE(section("In GLSL").empty());
  const glm::dvec3 expected = expected_colour();
  for (const ContextBackend backend : test_backends())
    for (const bool is_es : {false, true}) {
      SCOPED_TRACE(std::string(context_backend_name(backend)) + (is_es ? ", ES" : ""));
      const std::unique_ptr<HeadlessContext> context = make_test_context(backend);
      const GlFunctions& gl = context->functions();
      const GLuint program = linked(gl, is_es);
      if (HasFailure()) return;
      const Texture map = lobe_map(gl);
      const Framebuffer framebuffer(gl, 1, 1);
      const EmptyMesh full_screen(gl);
      framebuffer.bind();
      framebuffer.clear_colour(-1.0f);
      gl.Disable(GL_DEPTH_TEST);
      map.bind(0);
      gl.UseProgram(program);
      set_uniforms(gl, program);
      full_screen.draw_triangle();
      check_gl(gl, "the page's shader");
      const FloatImage image = framebuffer.read();
      gl.DeleteProgram(program);
      // The fit of Lambert's cosine has an error of at most 0.22 %, and the fit of the highlight at s = 40 has an error
      // of 0.5 %.
      for (glm::length_t c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<double>(image.rgba[static_cast<std::size_t>(c)]) / expected[c], 1.0, 0.006) << c;
      EXPECT_EQ(image.rgba[3], 1.0f);
    }
}

}  // namespace
}  // namespace multum::gl
