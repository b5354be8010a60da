// SPDX-License-Identifier: Apache-2.0
// Contexts and the function table.
#include <gtest/gtest.h>

#include <cstring>

#include "host/base/error.h"
#include "runtime_gl/context/headless_context.h"
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
    EXPECT_EQ(parse_context_backend(context_backend_name(backend)), backend);
  EXPECT_FALSE(parse_context_backend("glx").has_value());
}

// A driver of version 3.3 that lacks everything else.
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
  EXPECT_EQ(load_failure(), "the GL context has version 3.5, 4.5 or more is needed");
  fake_major = 4;
  EXPECT_EQ(load_failure(), "");
  fake_missing = "glDrawElements";
  EXPECT_EQ(load_failure(), "the GL driver has no function glDrawElements");
}

}  // namespace
}  // namespace multum::gl
