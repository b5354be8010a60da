// SPDX-License-Identifier: Apache-2.0
// Draws surfaces directly from pyramids (Williams 1983). The pyramids are colour maps (section 3) and reflectance maps
// (section 4). Either this code or the driver chooses the level, or the finest level is used. Also draws references and
// measures flicker.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "host/formats/asset/pyramid/pyramid_file.h"
#include "runtime_gl/gl/framebuffer.h"
#include "runtime_gl/gl/mesh.h"
#include "runtime_gl/gl/shader_program.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

/// Williams makes the texel width proportional to a pixel's width w, but does not give the factor. A trilinear lookup
/// at a level whose texels are as wide as the pixel blurs with a variance of w^2 / 4. Of this variance, w^2 / 12 is
/// from the texel's box and w^2 / 6 from the tent between texels. The pixel's own box has a variance of w^2 / 12. With
/// texels of width w / sqrt(3), the lookup has this variance too.
constexpr float kEqualVarianceBias = -0.79248125f;  // -log2(sqrt(3))

/// Lookup methods of a map.
enum class PyramidLookup {
  kNearest,   // nearest texel of the finest level, which Williams calls point sampling
  kBilinear,  // four texels of the finest level
  kLevel,     // trilinear, d chosen by common/pyramid.glsl
  kDriver,    // trilinear by the driver, with anisotropy if requested
};

/// Uploads every level of a pyramid as a texture, with nearest filtering for kNearest and trilinear filtering
/// otherwise.
Texture make_pyramid_texture(const GlFunctions& gl, const Pyramid& pyramid, PyramidLookup lookup, float anisotropy);

/// The axes of the view in the world, one per row: right, up, towards the distant viewer.
using ViewFrame = std::array<glm::vec3, 3>;

struct PyramidScene {
  Camera camera;
  float uv_scale = 1.0f;
  ViewFrame frame{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1)};
  glm::vec2 shift{0.0f};    // shift of the picture in pixels
  float level_bias = 0.0f;  // added to the level by kLevel and kDriver
};

/// Up to kLightCountMax distant lights on one Blinn-Phong surface.
struct PhongLights {
  std::vector<Light> lights;
  float exponent = 100.0f;
  glm::vec3 diffuse{0.5f}, specular{0.1f};
};

class PyramidRenderer {
 public:
  PyramidRenderer(const GlFunctions& gl, int width, int height) : gl_(gl), framebuffer_(gl, width, height) {}

  /// If `by_normal`, the map is a reflectance map.
  FloatImage draw(const Mesh& mesh, const Texture& map, PyramidLookup lookup, bool by_normal,
                  const PyramidScene& scene);
  /// Draws the levels of detail before clamping. Red is the level that common/pyramid.glsl chooses, and green is the
  /// level that the driver chooses (textureQueryLod).
  FloatImage draw_levels(const Mesh& mesh, const Texture& map, bool by_normal, const PyramidScene& scene);
  /// Shades in the fragment shader, without using a map.
  FloatImage draw_phong(const Mesh& mesh, const PhongLights& lights, const PyramidScene& scene);

 private:
  const ShaderProgram& program(const std::vector<std::string>& flags);
  FloatImage draw_with(const ShaderProgram& shader, const Mesh& mesh, const PyramidScene& scene);

  const GlFunctions& gl_;
  Framebuffer framebuffer_;
  std::map<std::string, std::unique_ptr<ShaderProgram>> programs_;
};

/// Returns the mean of side x side pictures, each shifted by a fraction of a pixel. `draw(shift)` draws one of them.
template <typename Draw>
FloatImage supersampled(int side, const Draw& draw) {
  FloatImage mean;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const auto offset = [&](int k) { return (static_cast<float>(k) + 0.5f) / static_cast<float>(side) - 0.5f; };
      FloatImage one = draw(glm::vec2(offset(i), offset(j)));
      if (mean.rgba.empty()) mean = {one.width, one.height, std::vector<float>(one.rgba.size())};
      for (std::size_t k = 0; k < one.rgba.size(); ++k) mean.rgba[k] += one.rgba[k] / static_cast<float>(side * side);
    }
  return mean;
}

/// Measures the flicker of pictures relative to their references over several shifts. Computes the variance of picture
/// - reference over the shifts. Returns the square root of the mean of this variance over the pixels, divided by the
/// reference's mean value. Returns 0 for black references.
double flicker(const std::vector<FloatImage>& pictures, const std::vector<FloatImage>& references);

}  // namespace multum::gl
