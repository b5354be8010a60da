// SPDX-License-Identifier: Apache-2.0
// Lists the EGL functions that this runtime calls. Only runtime_gl/context and its tests use this list.
#pragma once

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <memory>

#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/context/shared_library.h"

namespace multum::gl {

struct EglFunctions {
  EglFunctions() = default;
  explicit EglFunctions(const SharedLibrary& library)
      : GetProcAddress(library.symbol<PFNEGLGETPROCADDRESSPROC>("eglGetProcAddress")),
        GetError(library.symbol<PFNEGLGETERRORPROC>("eglGetError")),
        QueryString(library.symbol<PFNEGLQUERYSTRINGPROC>("eglQueryString")),
        Initialize(library.symbol<PFNEGLINITIALIZEPROC>("eglInitialize")),
        BindAPI(library.symbol<PFNEGLBINDAPIPROC>("eglBindAPI")),
        CreateContext(library.symbol<PFNEGLCREATECONTEXTPROC>("eglCreateContext")),
        MakeCurrent(library.symbol<PFNEGLMAKECURRENTPROC>("eglMakeCurrent")),
        DestroyContext(library.symbol<PFNEGLDESTROYCONTEXTPROC>("eglDestroyContext")) {}

  PFNEGLGETPROCADDRESSPROC GetProcAddress = nullptr;
  PFNEGLGETERRORPROC GetError = nullptr;
  PFNEGLQUERYSTRINGPROC QueryString = nullptr;
  PFNEGLINITIALIZEPROC Initialize = nullptr;
  PFNEGLBINDAPIPROC BindAPI = nullptr;
  PFNEGLCREATECONTEXTPROC CreateContext = nullptr;
  PFNEGLMAKECURRENTPROC MakeCurrent = nullptr;
  PFNEGLDESTROYCONTEXTPROC DestroyContext = nullptr;
};

/// Loads the functions from libEGL.so.1, which stays open. Throws Error(kEnvironment) if the library is missing.
EglFunctions load_egl_functions();

/// Does the work of make_egl_context() with these functions.
std::unique_ptr<HeadlessContext> make_egl_context(const EglFunctions& egl, DebugOutput debug);

}  // namespace multum::gl
