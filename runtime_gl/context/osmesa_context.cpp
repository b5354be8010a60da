// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/context/osmesa_context.h"

#include <array>
#include <cstdlib>

#include "host/foundation/base/error.h"
#include "runtime_gl/context/shared_library.h"

namespace multum::gl {
namespace {

// These declarations are from GL/osmesa.h, which includes the compatibility GL/gl.h and so conflicts with
// GL/glcorearb.h.
constexpr int kOsmesaFormat = 0x22;
constexpr int kOsmesaDepthBits = 0x30;
constexpr int kOsmesaStencilBits = 0x31;
constexpr int kOsmesaAccumBits = 0x32;
constexpr int kOsmesaProfile = 0x33;
constexpr int kOsmesaCoreProfile = 0x34;
constexpr int kOsmesaMajorVersion = 0x36;
constexpr int kOsmesaMinorVersion = 0x37;
constexpr int kOsmesaRgba = 0x1908;

constexpr int kDummySize = 4;

class OsmesaContext final : public HeadlessContext {
 public:
  explicit OsmesaContext(DebugOutput debug) : library_("libOSMesa.so.8") {
    const auto create = library_.symbol<void* (*)(const int*, void*)>("OSMesaCreateContextAttribs");
    make_current_ = library_.symbol<MakeCurrent>("OSMesaMakeCurrent");
    destroy_ = library_.symbol<Destroy>("OSMesaDestroyContext");
    const int attributes[] = {kOsmesaFormat,
                              kOsmesaRgba,
                              kOsmesaDepthBits,
                              0,
                              kOsmesaStencilBits,
                              0,
                              kOsmesaAccumBits,
                              0,
                              kOsmesaProfile,
                              kOsmesaCoreProfile,
                              kOsmesaMajorVersion,
                              4,
                              kOsmesaMinorVersion,
                              5,
                              0,
                              0};
    context_ = create(attributes, nullptr);
    if (context_ == nullptr) throw Error(ErrorCode::kEnvironment, "OSMesa: cannot create an OpenGL 4.5 core context");
    try {
      bind();
      load(library_.symbol<GetProcAddress>("OSMesaGetProcAddress"), debug);
    } catch (...) {
      destroy_(context_);
      throw;
    }
  }
  ~OsmesaContext() override { destroy_(context_); }

  void make_current() override { bind(); }
  ContextBackend backend() const override { return ContextBackend::kOsmesa; }

 private:
  using MakeCurrent = unsigned char (*)(void* context, void* buffer, unsigned type, int width, int height);
  using Destroy = void (*)(void* context);

  void bind() {
    if (make_current_(context_, dummy_.data(), GL_UNSIGNED_BYTE, kDummySize, kDummySize) == 0)
      throw Error(ErrorCode::kEnvironment, "OSMesa: OSMesaMakeCurrent failed");
  }

  SharedLibrary library_;
  MakeCurrent make_current_ = nullptr;
  Destroy destroy_ = nullptr;
  void* context_ = nullptr;
  std::array<unsigned char, kDummySize * kDummySize * 4> dummy_{};
};

}  // namespace

std::unique_ptr<HeadlessContext> make_osmesa_context(DebugOutput debug) {
  return std::make_unique<OsmesaContext>(debug);
}

}  // namespace multum::gl
