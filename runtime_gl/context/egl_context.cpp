// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/context/egl_context.h"

#include <array>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "host/foundation/base/error.h"
#include "runtime_gl/context/egl_functions.h"

namespace multum::gl {
namespace {

const char* egl_error_name(EGLint error) {
  switch (error) {
    case EGL_SUCCESS: return "EGL_SUCCESS";
    case EGL_NOT_INITIALIZED: return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS: return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC: return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE: return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG: return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT: return "EGL_BAD_CONTEXT";
    case EGL_BAD_DISPLAY: return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH: return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER: return "EGL_BAD_PARAMETER";
    default: return "unknown EGL error";
  }
}

/// Matches whole words only, because the name of one extension can begin with the name of another.
bool has_word(const char* list, const char* word) {
  if (list == nullptr) return false;
  const std::size_t length = std::strlen(word);
  for (const char* at = std::strstr(list, word); at != nullptr; at = std::strstr(at + 1, word))
    if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return true;
  return false;
}

struct Candidate {
  std::string name;
  EGLDisplay display;
  bool is_software = false;
};

// Sorts displays. GPUs come first, then the display of the surfaceless platform, then software renderers.
std::vector<Candidate> candidate_displays(const EglFunctions& egl) {
  std::vector<Candidate> candidates;
  const char* client = egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto get_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(egl.GetProcAddress("eglGetPlatformDisplayEXT"));
  if (get_display == nullptr || !has_word(client, "EGL_EXT_platform_base")) return candidates;
  std::vector<Candidate> software;
  const auto query_devices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(egl.GetProcAddress("eglQueryDevicesEXT"));
  const auto query_text =
      reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(egl.GetProcAddress("eglQueryDeviceStringEXT"));
  const bool has_devices = has_word(client, "EGL_EXT_device_enumeration") || has_word(client, "EGL_EXT_device_base");
  if (query_devices != nullptr && has_devices && has_word(client, "EGL_EXT_platform_device")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE)
      for (EGLint i = 0; i < count; ++i) {
        const EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
        const bool is_software =
            query_text != nullptr && has_word(query_text(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
        (is_software ? software : candidates)
            .push_back(
                {"device " + std::to_string(i), get_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr), is_software});
      }
  }
  if (has_word(client, "EGL_MESA_platform_surfaceless"))
    candidates.push_back({"surfaceless", get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)});
  candidates.insert(candidates.end(), software.begin(), software.end());
  return candidates;
}

class EglContext final : public HeadlessContext {
 public:
  // Opens a context on the first display that gives a usable one, or only on the display with the given number.
  EglContext(const EglFunctions& egl, DebugOutput debug, std::optional<std::size_t> only = std::nullopt) : egl_(egl) {
    std::string reasons;
    const std::vector<Candidate> candidates = candidate_displays(egl_);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const Candidate& candidate = candidates[i];
      if (only && i != *only) continue;
      std::string reason = open(candidate.display, debug);
      if (reason.empty()) reason = load_or_close(debug);
      if (reason.empty()) return;
      reasons += (reasons.empty() ? "" : "; ") + candidate.name + ": " + reason;
    }
    throw Error(
        ErrorCode::kEnvironment,
        "EGL: " + (reasons.empty() ? "the library has neither the surfaceless nor the device platform" : reasons));
  }
  ~EglContext() override { close(); }

  void make_current() override {
    egl_.BindAPI(EGL_OPENGL_API);
    if (egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE)
      throw Error(ErrorCode::kEnvironment, std::string("EGL: eglMakeCurrent: ") + egl_error_name(egl_.GetError()));
  }
  ContextBackend backend() const override { return ContextBackend::kEgl; }

 private:
  /// Makes the context current. Returns an empty string, or the reason for the failure.
  std::string open(EGLDisplay display, DebugOutput debug) {
    EGLint major = 0;
    EGLint minor = 0;
    if (display == EGL_NO_DISPLAY) return "no display";
    if (egl_.Initialize(display, &major, &minor) != EGL_TRUE) return failure("eglInitialize");
    const char* extensions = egl_.QueryString(display, EGL_EXTENSIONS);
    for (const char* needed : {"EGL_KHR_no_config_context", "EGL_KHR_surfaceless_context", "EGL_KHR_create_context"})
      if (!has_word(extensions, needed)) return std::string("no ") + needed;
    if (egl_.BindAPI(EGL_OPENGL_API) != EGL_TRUE) return failure("eglBindAPI(EGL_OPENGL_API)");
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 4,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 5,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_CONTEXT_OPENGL_DEBUG,
                                 debug == DebugOutput::kOn ? EGL_TRUE : EGL_FALSE,
                                 EGL_NONE};
    const EGLContext context = egl_.CreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT) return failure("eglCreateContext for OpenGL 4.5 core");
    display_ = display;
    context_ = context;
    if (egl_.MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE) return "";
    const std::string reason = failure("eglMakeCurrent");
    close();
    return reason;
  }
  std::string failure(const char* call) { return std::string(call) + ": " + egl_error_name(egl_.GetError()); }
  /// Loads the context's functions. Returns an empty string, or closes the context and returns the reason, so that
  /// another display can be tried.
  std::string load_or_close(DebugOutput debug) {
    try {
      load(reinterpret_cast<GetProcAddress>(egl_.GetProcAddress), debug);
      return "";
    } catch (const Error& error) {
      close();
      return error.what();
    } catch (...) {
      close();
      throw;
    }
  }
  // The display stays initialised, because Mesa gives the same display to every caller, and eglTerminate would end the
  // contexts of other callers.
  void close() {
    if (context_ == EGL_NO_CONTEXT) return;
    egl_.MakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    egl_.DestroyContext(display_, context_);
    context_ = EGL_NO_CONTEXT;
  }

  const EglFunctions egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

EglFunctions load_egl_functions() { return EglFunctions(SharedLibrary("libEGL.so.1")); }

std::unique_ptr<HeadlessContext> make_egl_context(const EglFunctions& egl, DebugOutput debug) {
  return std::make_unique<EglContext>(egl, debug);
}

std::unique_ptr<HeadlessContext> make_egl_context(DebugOutput debug) {
  return make_egl_context(load_egl_functions(), debug);
}

std::vector<EglOffer> list_egl_offers() {
  const EglFunctions egl = load_egl_functions();
  const std::vector<Candidate> candidates = candidate_displays(egl);
  std::vector<EglOffer> offers;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    EglOffer offer{candidates[i].name, candidates[i].is_software, "", ""};
    try {
      offer.description = EglContext(egl, DebugOutput::kOff, i).description();
    } catch (const Error& error) {
      offer.reason = error.what();
    }
    offers.push_back(std::move(offer));
  }
  return offers;
}

}  // namespace multum::gl
