// SPDX-License-Identifier: Apache-2.0
// Tests GL contexts and the function table.
#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <utility>

#include "host/foundation/base/error.h"
#include "runtime_gl/context/egl_functions.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/gl/shader_program.h"
#include "tests/gl/test_context.h"

namespace multum::gl {
namespace {

class ContextTest : public testing::TestWithParam<ContextBackend> {};

TEST_P(ContextTest, GivesCore45) {
  const auto context = make_headless_context(GetParam());
  EXPECT_EQ(context->backend(), GetParam());
  GLint profile = 0;
  context->functions().GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
  EXPECT_NO_THROW(check_gl(context->functions(), "after creation"));
  EXPECT_EQ(context->description().find(context_backend_name(GetParam())), 0u);
}

TEST_P(ContextTest, ErrorsCarryStepAndSymbol) {
  const auto context = make_headless_context(GetParam());
  context->functions().Enable(0xFFFF);
  try {
    check_gl(context->functions(), "the step");
    FAIL() << "no error was reported";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
    EXPECT_STREQ(error.what(), "the step: GL_INVALID_ENUM");
  }
  EXPECT_NO_THROW(check_gl(context->functions(), "flags are cleared"));
}

TEST_P(ContextTest, ExtensionsAreWholeNames) {
  const auto context = make_headless_context(GetParam());
  EXPECT_TRUE(has_gl_extension(context->functions(), "GL_EXT_texture_filter_anisotropic"));
  EXPECT_FALSE(has_gl_extension(context->functions(), "GL_EXT_texture_filter"));
}

// With debug output, a driver waits for each call to finish, so everything takes longer.
TEST_P(ContextTest, DebugOutputIsOnOnlyWhereItIsWanted) {
  for (const DebugOutput debug : {DebugOutput::kOff, DebugOutput::kOn}) {
    const auto context = make_headless_context(GetParam(), debug);
    const GlFunctions& gl = context->functions();
    for (const GLenum state : {GL_DEBUG_OUTPUT, GL_DEBUG_OUTPUT_SYNCHRONOUS}) {
      GLint is_on = -1;
      gl.GetIntegerv(state, &is_on);
      EXPECT_EQ(is_on, debug == DebugOutput::kOn ? 1 : 0) << std::hex << state;
    }
    GLint flags = 0;
    gl.GetIntegerv(GL_CONTEXT_FLAGS, &flags);
    EXPECT_TRUE(debug == DebugOutput::kOn || (flags & GL_CONTEXT_FLAG_DEBUG_BIT) == 0);
  }
#ifndef MULTUM_DEBUG_CHECKS
  EXPECT_EQ(kUsualDebugOutput, DebugOutput::kOff);
#endif
}

// The driver reports an error after it has linked a program. The exception must delete the program.
GLenum raised_error = GL_NO_ERROR;
GLenum APIENTRY raise_error() { return std::exchange(raised_error, static_cast<GLenum>(GL_NO_ERROR)); }
int programs_made = 0, shaders_made = 0;
GlFunctions counted_functions;  // the context's own functions, wrapped with counters
GLuint APIENTRY count_program() { return ++programs_made, counted_functions.CreateProgram(); }
void APIENTRY discount_program(GLuint id) { --programs_made, counted_functions.DeleteProgram(id); }
GLuint APIENTRY count_shader(GLenum stage) { return ++shaders_made, counted_functions.CreateShader(stage); }
void APIENTRY discount_shader(GLuint id) { --shaders_made, counted_functions.DeleteShader(id); }

TEST_P(ContextTest, AProgramThatCannotBeUsedIsDeleted) {
  const auto context = make_headless_context(GetParam());
  counted_functions = context->functions();
  GlFunctions gl = counted_functions;
  gl.GetError = raise_error;
  gl.CreateProgram = count_program;
  gl.DeleteProgram = discount_program;
  gl.CreateShader = count_shader;
  gl.DeleteShader = discount_shader;
  const ShaderSources sources = {"dot", {}, {"void main() { gl_Position = vec4(0.0); }"}, {"void main() {}"}};
  raised_error = GL_OUT_OF_MEMORY;
  EXPECT_THROW(ShaderProgram(gl, sources), Error);
  EXPECT_EQ(programs_made, 0);
  EXPECT_EQ(shaders_made, 0);
  EXPECT_THROW(ShaderProgram(gl, {"odd", {}, {"void main() {}"}, {"nonsense"}}), Error);
  EXPECT_THROW(ShaderProgram(gl, {"odd", {}, {"void main() { f(); } void f();"}, {"void main() {}"}}), Error);
  EXPECT_EQ(programs_made, 0);
  EXPECT_EQ(shaders_made, 0);
  EXPECT_NO_THROW(ShaderProgram(gl, sources));
  EXPECT_EQ(programs_made, 0);
}

INSTANTIATE_TEST_SUITE_P(Backends, ContextTest, testing::ValuesIn(test_backends()),
                         [](const auto& test) { return std::string(context_backend_name(test.param)); });

TEST(Context, BothLiveInOneProcess) {
  if (test_backends().size() < 2) GTEST_SKIP() << "MULTUM_TEST_GL names one context";
  const auto osmesa = make_headless_context(ContextBackend::kOsmesa);
  const auto egl = make_headless_context(ContextBackend::kEgl);
  GLuint texture = 0;
  for (HeadlessContext* context : {osmesa.get(), egl.get(), osmesa.get()}) {
    context->make_current();
    context->functions().CreateTextures(GL_TEXTURE_2D, 1, &texture);
    EXPECT_NO_THROW(check_gl(context->functions(), "creating a texture"));
  }
}

TEST(Context, NamesRoundTrip) {
  for (const ContextBackend backend : {ContextBackend::kAuto, ContextBackend::kOsmesa, ContextBackend::kEgl})
    EXPECT_EQ(find_choice(kContextBackends, context_backend_name(backend)), backend);
  EXPECT_FALSE(find_choice(kContextBackends, "glx").has_value());
}

// Imitates a driver of version 3.3 without any other feature.
GLint fake_major = 3;
const char* fake_missing = "";
void APIENTRY fake_get_integer(GLenum name, GLint* value) { *value = name == GL_MAJOR_VERSION ? fake_major : 5; }
void fake_function() {}
GlFunction fake_get_proc_address(const char* name) {
  if (std::strcmp(name, "glGetIntegerv") == 0) return reinterpret_cast<GlFunction>(fake_get_integer);
  return std::strcmp(name, fake_missing) == 0 ? nullptr : fake_function;
}

std::string load_failure() {
  try {
    load_gl_functions(fake_get_proc_address);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
    return error.what();
  }
  return "";
}

TEST(Loader, RefusesOldVersionsAndMissingFunctions) {
  fake_major = 3;
  EXPECT_EQ(load_failure(), "the GL context has version 3.5, expected 4.5 or later");
  fake_major = 4;
  EXPECT_EQ(load_failure(), "");
  fake_missing = "glDrawElements";
  EXPECT_EQ(load_failure(), "the GL driver has no function glDrawElements");
}

// Imitates EGL with three displays. The first two give contexts of unusable drivers, and the last one gives a usable
// context.
EGLDisplay fake_displays[3];
EGLDisplay fake_current = EGL_NO_DISPLAY;
int fake_contexts = 0;
bool fake_last_is_good = true;

EGLDisplay fake_display(int number) { return &fake_displays[number]; }
const char* EGLAPIENTRY fake_query_string(EGLDisplay display, EGLint) {
  return display == EGL_NO_DISPLAY
             ? "EGL_EXT_platform_base EGL_EXT_device_base EGL_EXT_platform_device EGL_MESA_platform_surfaceless"
             : "EGL_KHR_no_config_context EGL_KHR_surfaceless_context EGL_KHR_create_context";
}
EGLBoolean EGLAPIENTRY fake_query_devices(EGLint, EGLDeviceEXT* devices, EGLint* count) {
  devices[0] = fake_display(0);
  devices[1] = fake_display(1);
  *count = 2;
  return EGL_TRUE;
}
EGLDisplay EGLAPIENTRY fake_get_display(EGLenum, void* device, const EGLint*) {
  return device == EGL_DEFAULT_DISPLAY ? fake_display(2) : device;
}
EGLBoolean EGLAPIENTRY fake_initialize(EGLDisplay, EGLint*, EGLint*) { return EGL_TRUE; }
EGLBoolean EGLAPIENTRY fake_bind_api(EGLenum) { return EGL_TRUE; }
EGLContext EGLAPIENTRY fake_create_context(EGLDisplay, EGLConfig, EGLContext, const EGLint*) {
  return ++fake_contexts, &fake_contexts;
}
EGLBoolean EGLAPIENTRY fake_make_current(EGLDisplay display, EGLSurface, EGLSurface, EGLContext context) {
  fake_current = context == EGL_NO_CONTEXT ? EGL_NO_DISPLAY : display;
  return EGL_TRUE;
}
EGLBoolean EGLAPIENTRY fake_destroy_context(EGLDisplay, EGLContext) { return --fake_contexts, EGL_TRUE; }
EGLint EGLAPIENTRY fake_get_egl_error() { return EGL_SUCCESS; }
void APIENTRY fake_get_version(GLenum name, GLint* value) {
  *value = name == GL_MAJOR_VERSION ? (fake_current == fake_display(0) ? 3 : 4) : 5;
}
const GLubyte* APIENTRY fake_get_string(GLenum) { return reinterpret_cast<const GLubyte*>("fake"); }
__eglMustCastToProperFunctionPointerType EGLAPIENTRY fake_egl_proc(const char* name) {
  const std::string wanted = name;
  using Function = __eglMustCastToProperFunctionPointerType;
  if (wanted == "eglGetPlatformDisplayEXT") return reinterpret_cast<Function>(fake_get_display);
  if (wanted == "eglQueryDevicesEXT") return reinterpret_cast<Function>(fake_query_devices);
  if (wanted == "eglQueryDeviceStringEXT") return nullptr;
  if (wanted == "glGetIntegerv") return reinterpret_cast<Function>(fake_get_version);
  if (wanted == "glGetString") return reinterpret_cast<Function>(fake_get_string);
  const bool is_bad = fake_current == fake_display(1) || (fake_current == fake_display(2) && !fake_last_is_good);
  return is_bad && wanted == "glDrawElements" ? nullptr : reinterpret_cast<Function>(fake_function);
}

EglFunctions fake_egl() {
  EglFunctions egl;
  egl.GetProcAddress = fake_egl_proc;
  egl.GetError = fake_get_egl_error;
  egl.QueryString = fake_query_string;
  egl.Initialize = fake_initialize;
  egl.BindAPI = fake_bind_api;
  egl.CreateContext = fake_create_context;
  egl.MakeCurrent = fake_make_current;
  egl.DestroyContext = fake_destroy_context;
  return egl;
}

TEST(EglSearch, GoesOnBehindADisplayWhoseDriverIsOfNoUse) {
  fake_last_is_good = true;
  {
    const auto context = make_egl_context(fake_egl(), DebugOutput::kOff);
    EXPECT_EQ(fake_current, fake_display(2));
    EXPECT_EQ(fake_contexts, 1) << "the contexts before are gone";
  }
  EXPECT_EQ(fake_contexts, 0);
  fake_last_is_good = false;
  try {
    make_egl_context(fake_egl(), DebugOutput::kOff);
    FAIL() << "no display is of any use";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kEnvironment);
    EXPECT_STREQ(error.what(),
                 "EGL: device 0: the GL context has version 3.5, expected 4.5 or later; device 1: the GL driver has no "
                 "function glDrawElements; surfaceless: the GL driver has no function glDrawElements");
  }
  EXPECT_EQ(fake_contexts, 0);
}

}  // namespace
}  // namespace multum::gl
