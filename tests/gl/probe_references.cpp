// SPDX-License-Identifier: Apache-2.0
#include "tests/gl/probe_references.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/type_ptr.hpp>

#include "runtime_gl/gl/texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

int level_count(const ProbeCase& probe) {
  return probe.sampler.has_mips ? MipLayout(probe.mapping.width, probe.mapping.height).level_count() : 1;
}

// Draws several textures of one case.
class CaseRenderer {
 public:
  CaseRenderer(const ProbeCase& probe, int supersampling)
      : probe_(probe),
        layout_(probe.mapping.width, probe.mapping.height),
        texture_(*probe.gl, "test",
                 {probe.mapping.width, probe.mapping.height, level_count(probe), TexelFormat::kRgba32f},
                 {probe.mapping.wrap_s, probe.mapping.wrap_t, true, probe.sampler.anisotropy}),
        renderer_(*probe.gl, probe.width, probe.height, supersampling) {}

  FloatImage draw(const std::vector<float>& texels) {
    for (int l = 0; l < level_count(probe_); ++l)
      texture_.upload_level(l, texels.data() + 4 * layout_.levels[static_cast<std::size_t>(l)].offset);
    std::vector<TexturedObject> objects;
    for (std::size_t i = 0; i < probe_.objects.size(); ++i)
      objects.push_back({probe_.objects[i],
                         i == probe_.object ? std::vector<const Texture*>{&texture_} : std::vector<const Texture*>{}});
    return renderer_.draw(objects);
  }
  const MipLayout& layout() const { return layout_; }

 private:
  const ProbeCase& probe_;
  MipLayout layout_;
  Texture texture_;
  TexturedRenderer renderer_;
};

std::size_t pixel_count(const ProbeCase& probe) {
  return static_cast<std::size_t>(probe.width) * static_cast<std::size_t>(probe.height);
}

int wrapped(int i, int count, WrapMode mode) { return mode == WrapMode::kPeriodic ? ((i % count) + count) % count : i; }

// Writes an identifier into the green and blue channels of a rectangle of texels in one level.
void mark(std::vector<float>& texels, const MipLevelPlace& level, const TextureMapping& mapping, int x0, int x1, int y0,
          int y1, std::size_t identifier) {
  if (x1 - x0 >= level.width) x0 = 0, x1 = level.width - 1;
  if (y1 - y0 >= level.height) y0 = 0, y1 = level.height - 1;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const int tx = wrapped(x, level.width, mapping.wrap_s), ty = wrapped(y, level.height, mapping.wrap_t);
      if (tx < 0 || ty < 0 || tx >= level.width || ty >= level.height) continue;
      float* texel = &texels[4u * static_cast<std::size_t>(level.offset + ty * level.width + tx)];
      texel[1] = static_cast<float>(identifier % 256);
      texel[2] = static_cast<float>(identifier / 256);
    }
}

// Sets the texels for one of the paper's renderings, which are every `step`-th texel from (ox, oy) in every third level
// from `first_level`.
std::vector<std::uint32_t> set_apart(const ProbeCase& probe, const MipLayout& layout, int first_level, int ox, int oy,
                                     int step, std::vector<float>& texels) {
  std::vector<std::uint32_t> identifiers = {0};
  for (int l = first_level; l < layout.level_count(); l += 3) {
    const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
    for (int y = oy; y < level.height; y += step)
      for (int x = ox; x < level.width; x += step) {
        const std::size_t id = identifiers.size();
        const int texel = level.offset + y * level.width + x;
        identifiers.push_back(static_cast<std::uint32_t>(texel));
        mark(texels, level, probe.mapping, x - 1, x + 1, y - 1, y + 1, id);
        const int cx = x >> 1, cy = y >> 1;
        if (l + 1 < layout.level_count())
          mark(texels, layout.levels[static_cast<std::size_t>(l + 1)], probe.mapping, cx - 1, cx + 1, cy - 1, cy + 1,
               id);
        if (l > 0)
          mark(texels, layout.levels[static_cast<std::size_t>(l - 1)], probe.mapping, 2 * x - 2, 2 * x + 3, 2 * y - 2,
               2 * y + 3, id);
        texels[4u * static_cast<std::size_t>(texel)] = 1.0f;
      }
  }
  return identifiers;
}

}  // namespace

FloatImage draw_texels(const ProbeCase& probe, int supersampling, const std::vector<float>& texels) {
  return CaseRenderer(probe, supersampling).draw(texels);
}

ProbeRows probe_texel_by_texel(const ProbeCase& probe) {
  CaseRenderer renderer(probe, 1);
  ProbeRows rows(pixel_count(probe));
  std::vector<float> texels(4u * static_cast<std::size_t>(renderer.layout().texel_count), 0.0f);
  for (std::uint32_t texel = 0; texel < static_cast<std::uint32_t>(renderer.layout().texel_count); ++texel) {
    texels[4u * texel] = 1.0f;
    const FloatImage picture = renderer.draw(texels);
    texels[4u * texel] = 0.0f;
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (picture.rgba[4 * i] != 0.0f) rows[i][texel] = static_cast<double>(picture.rgba[4 * i]);
  }
  return rows;
}

ProbeRows probe_in_parallel(const ProbeCase& probe) {
  const bool periodic = probe.mapping.wrap_s == WrapMode::kPeriodic || probe.mapping.wrap_t == WrapMode::kPeriodic;
  const int step = periodic ? 8 : 6;
  CaseRenderer renderer(probe, 1);
  ProbeRows rows(pixel_count(probe));
  for (int l = 0; l < 3; ++l)
    for (int oy = 0; oy < step; ++oy)
      for (int ox = 0; ox < step; ++ox) {
        std::vector<float> texels(4u * static_cast<std::size_t>(renderer.layout().texel_count), 0.0f);
        const auto identifiers = set_apart(probe, renderer.layout(), l, ox, oy, step, texels);
        const FloatImage picture = renderer.draw(texels);
        for (std::size_t i = 0; i < rows.size(); ++i) {
          const float weight = picture.rgba[4 * i];
          if (weight == 0.0f) continue;
          // The whole filter neighbourhood holds the identifier, so that filtering does not change it.
          const auto id = static_cast<std::size_t>(std::lround(picture.rgba[4 * i + 1]) +
                                                   256 * std::lround(picture.rgba[4 * i + 2]));
          if (id < identifiers.size()) rows[i][identifiers[id]] += static_cast<double>(weight);
        }
      }
  return rows;
}

ProbeRows rows_by_query_lod(const ProbeCase& probe) {
  const GlFunctions& gl = *probe.gl;
  Texture texture(gl, "test", {probe.mapping.width, probe.mapping.height, level_count(probe), TexelFormat::kRgba32f},
                  {probe.mapping.wrap_s, probe.mapping.wrap_t, true, probe.sampler.anisotropy});
  const ShaderProgram shader(
      gl, {"query_lod",
           {},
           {shader_textured_vert},
           {"in vec2 v_st; uniform sampler2D u_t; uniform float u_seen; layout(location = 0) out vec4 o;\n"
            "void main() { o = u_seen * vec4(v_st, textureQueryLod(u_t, v_st).y, 1.0); }"}});
  const Framebuffer framebuffer(gl, probe.width, probe.height);
  framebuffer.bind();
  framebuffer.clear_colour();
  framebuffer.clear_depth();
  gl.Enable(GL_DEPTH_TEST);
  texture.bind(0);
  shader.use();
  for (std::size_t i = 0; i < probe.objects.size(); ++i) {
    shader.set("u_seen", i == probe.object ? 1.0f : 0.0f);
    shader.set_mat4("u_object_to_clip", glm::value_ptr(probe.objects[i].object_to_clip));
    probe.objects[i].mesh->draw();
  }
  const FloatImage place = framebuffer.read();
  const MipLayout layout(probe.mapping.width, probe.mapping.height);
  const auto coordinate = [](float value, WrapMode mode) {
    const double s = static_cast<double>(value);
    return mode == WrapMode::kPeriodic ? s - std::floor(s) : s;
  };
  ProbeRows rows(pixel_count(probe));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (place.rgba[4 * i + 3] == 0.0f) continue;
    const double lod = std::clamp(static_cast<double>(place.rgba[4 * i + 2]), 0.0, level_count(probe) - 1.0);
    for (int k = 0; k < 2; ++k) {
      const int l = std::min(static_cast<int>(lod) + k, level_count(probe) - 1);
      const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
      const double fraction = lod - std::floor(lod), share = k == 0 ? 1.0 - fraction : fraction;
      const double x = coordinate(place.rgba[4 * i], probe.mapping.wrap_s) * level.width - 0.5;
      const double y = coordinate(place.rgba[4 * i + 1], probe.mapping.wrap_t) * level.height - 0.5;
      const double fx = x - std::floor(x), fy = y - std::floor(y);
      for (int dy = 0; dy < 2; ++dy)
        for (int dx = 0; dx < 2; ++dx) {
          const auto place_of = [](double at, int d, int count, WrapMode mode) {
            const int index = static_cast<int>(std::floor(at)) + d;
            return mode == WrapMode::kPeriodic ? ((index % count) + count) % count : std::clamp(index, 0, count - 1);
          };
          const int texel = level.offset + place_of(y, dy, level.height, probe.mapping.wrap_t) * level.width +
                            place_of(x, dx, level.width, probe.mapping.wrap_s);
          rows[i][static_cast<std::uint32_t>(texel)] += share * (dx == 0 ? 1.0 - fx : fx) * (dy == 0 ? 1.0 - fy : fy);
        }
    }
  }
  return rows;
}

double largest_difference(const ProbeRows& a, const ProbeRows& b) {
  double largest = 0.0;
  const auto compare = [&](const ProbeRows& from, const ProbeRows& to) {
    for (std::size_t i = 0; i < from.size(); ++i)
      for (const auto& [texel, weight] : from[i]) {
        const auto other = to[i].find(texel);
        largest = std::max(largest, std::abs(weight - (other == to[i].end() ? 0.0 : other->second)));
      }
  };
  compare(a, b);
  compare(b, a);
  return largest;
}

ProbeRows rows_of(const FilterMatrix& matrix) {
  ProbeRows rows(static_cast<std::size_t>(matrix.width) * static_cast<std::size_t>(matrix.height));
  for (std::size_t r = 0; r < matrix.row_count(); ++r)
    for (std::uint32_t i = matrix.row_begin[r]; i < matrix.row_begin[r + 1]; ++i)
      rows[matrix.pixels[r]][matrix.columns[i]] += static_cast<double>(matrix.weights[i]);
  return rows;
}

}  // namespace multum::gl
