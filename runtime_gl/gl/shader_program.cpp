// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/shader_program.h"

#include <numeric>

#include "host/foundation/base/error.h"

namespace multum::gl {
namespace {

std::string variant_name(const ShaderSources& sources) {
  std::string name = "shader '" + sources.name + "'";
  for (const std::string& flag : sources.flags) name += " " + flag;
  return name;
}

std::string preamble(const ShaderSources& sources) {
  std::string text = "#version 450 core\n";
  for (const std::string& flag : sources.flags) text += "#define " + flag + "\n";
  return text;
}

std::string shader_log(const GlFunctions& gl, GLuint shader) {
  GLint length = 0;
  gl.GetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) gl.GetShaderInfoLog(shader, length, nullptr, log.data());
  return log;
}

std::string program_log(const GlFunctions& gl, GLuint program) {
  GLint length = 0;
  gl.GetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(length), '\0');
  if (length > 0) gl.GetProgramInfoLog(program, length, nullptr, log.data());
  return log;
}

class Shader {
 public:
  Shader(const GlFunctions& gl, GLenum stage) : gl_(gl), id_(gl.CreateShader(stage)) {}
  ~Shader() { gl_.DeleteShader(id_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  GLuint id() const { return id_; }

 private:
  const GlFunctions& gl_;
  const GLuint id_;
};

void compile(const GlFunctions& gl, GLenum stage, const ShaderSources& sources, GLuint shader) {
  const bool is_vertex = stage == GL_VERTEX_SHADER;
  const std::string head = preamble(sources);
  std::vector<const GLchar*> texts = {head.c_str()};
  for (const std::string& text : is_vertex ? sources.vertex : sources.fragment) texts.push_back(text.c_str());
  gl.ShaderSource(shader, static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
  gl.CompileShader(shader);
  GLint ok = GL_FALSE;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return;
  throw Error(ErrorCode::kEnvironment, variant_name(sources) + ": the driver cannot compile the " +
                                           (is_vertex ? "vertex" : "fragment") +
                                           " shader (text 0 is the version and the flags):\n" + shader_log(gl, shader));
}

}  // namespace

ShaderProgram::ShaderProgram(const GlFunctions& gl) : gl_(&gl), id_(gl.CreateProgram()) {}

// The delegated constructor is complete, so the destructor deletes the program even if this constructor throws.
ShaderProgram::ShaderProgram(const GlFunctions& gl, const ShaderSources& sources) : ShaderProgram(gl) {
  const Shader vertex(gl, GL_VERTEX_SHADER), fragment(gl, GL_FRAGMENT_SHADER);
  compile(gl, GL_VERTEX_SHADER, sources, vertex.id());
  compile(gl, GL_FRAGMENT_SHADER, sources, fragment.id());
  gl.AttachShader(id_, vertex.id());
  gl.AttachShader(id_, fragment.id());
  gl.LinkProgram(id_);
  GLint ok = GL_FALSE;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE)
    throw Error(ErrorCode::kEnvironment,
                variant_name(sources) + ": the driver cannot link it:\n" + program_log(gl, id_));
  check_gl(gl, "building " + variant_name(sources));
}

ShaderProgram::~ShaderProgram() { gl_->DeleteProgram(id_); }

std::vector<std::string> ShaderProgram::active_uniforms() const {
  GLint count = 0, longest = 0;
  gl_->GetProgramiv(id_, GL_ACTIVE_UNIFORMS, &count);
  gl_->GetProgramiv(id_, GL_ACTIVE_UNIFORM_MAX_LENGTH, &longest);
  std::vector<std::string> names;
  for (GLint i = 0; i < count; ++i) {
    std::string name(static_cast<std::size_t>(longest), '\0');
    GLsizei length = 0;
    GLint size = 0;
    GLenum type = 0;
    gl_->GetActiveUniform(id_, static_cast<GLuint>(i), longest, &length, &size, &type, name.data());
    name.resize(static_cast<std::size_t>(length));
    names.push_back(name.substr(0, name.find('[')));
  }
  return names;
}

void ShaderProgram::set(const char* uniform, int value) const { gl_->ProgramUniform1i(id_, location(uniform), value); }

void ShaderProgram::set(const char* uniform, float value) const {
  gl_->ProgramUniform1f(id_, location(uniform), value);
}

void ShaderProgram::set_floats(const char* uniform, const float* values, int count) const {
  gl_->ProgramUniform1fv(id_, location(uniform), count, values);
}

void ShaderProgram::set_vec2(const char* uniform, const float* values) const {
  gl_->ProgramUniform2fv(id_, location(uniform), 1, values);
}

void ShaderProgram::set_vec3(const char* uniform, const float* values, int count) const {
  gl_->ProgramUniform3fv(id_, location(uniform), count, values);
}

void ShaderProgram::set_mat4(const char* uniform, const float* column_major) const {
  gl_->ProgramUniformMatrix4fv(id_, location(uniform), 1, GL_FALSE, column_major);
}

void ShaderProgram::set_units(const char* uniform, int first_unit, int count) const {
  std::vector<GLint> units(static_cast<std::size_t>(count));
  std::iota(units.begin(), units.end(), first_unit);
  gl_->ProgramUniform1iv(id_, location(uniform), count, units.data());
}

}  // namespace multum::gl
