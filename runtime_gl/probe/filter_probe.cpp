// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/probe/filter_probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/gtc/type_ptr.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/split_mix.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/probe/texel_classes.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

constexpr int kClassesADraw = 8;
constexpr int kProbeBuffers = 6;
constexpr int kDigit = 512;  // numbers in base 512 stay exact in floats for 2^26 texels
constexpr float kRowSumTolerance = 1e-4f;
constexpr float kDigitTolerance = 0.1f;
constexpr float kWitnessTolerance = 1e-5f;

struct Entry {
  std::uint32_t texel;
  float weight;
};

// Returns the number of texels of a level that a footprint is first assumed to reach. A footprint with anisotropy a is
// a texels long, and bilinear filtering adds one texel.
int first_span(const ProbeSampler& sampler) {
  return sampler.anisotropy > 1.0f ? static_cast<int>(std::ceil(sampler.anisotropy)) + 3 : 2;
}

// Returns the largest number of texels that a footprint can reach. An ellipse of llvmpipe with anisotropy a reaches 2 a
// texels to both sides, because its level is rounded down.
int last_span(const ProbeSampler& sampler) {
  return sampler.anisotropy > 1.0f ? 4 * static_cast<int>(std::ceil(sampler.anisotropy)) + 8 : 2;
}

ShaderSources probe_sources(std::vector<std::string> flags) {
  return {"filter_probe", std::move(flags), {shader_textured_vert}, {shader_filter_probe_frag}};
}

// Returns one of four pseudo-random values from 0 to 1 per texel.
float witness_value(int texel, int channel) {
  const std::uint64_t bits = split_mix(4u * static_cast<std::uint64_t>(texel) + static_cast<std::uint64_t>(channel));
  return static_cast<float>(bits >> 40) * 0x1p-24f;
}

// The textures of one draw. For classes, textures 0 and 1 mark their texels, 2 and 3 hold the low digit of the texels'
// numbers + 1, and 4 and 5 hold the high digit. For the random test texture ("witness"), texture 0 holds random values.
class ProbeTextures {
 public:
  ProbeTextures(const GlFunctions& gl, const MipLayout& layout, const TextureShape& shape,
                const SamplerSettings& sampler)
      : layout_(layout) {
    textures_.reserve(kProbeBuffers);
    for (int i = 0; i < kProbeBuffers; ++i) textures_.emplace_back(gl, "probe texture", shape, sampler);
  }

  void upload(const TexelClasses& classes, int first_class) {
    std::array<std::vector<float>, kProbeBuffers> data;
    for (int l = 0; l < textures_[0].shape().level_count; ++l) {
      const MipLevelPlace& level = layout_.levels[static_cast<std::size_t>(l)];
      const std::size_t count = 4u * static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
      for (auto& values : data) values.assign(count, 0.0f);
      for (int y = 0, i = 0; y < level.height; ++y)
        for (int x = 0; x < level.width; ++x, ++i) {
          const int channel = classes.class_of(l, x, y) - first_class;
          if (channel < 0 || channel >= kClassesADraw) continue;
          const auto at = static_cast<std::size_t>(4 * i + channel % 4);
          const auto half = static_cast<std::size_t>(channel / 4);
          const int number = level.offset + i + 1;
          data[half][at] = 1.0f;
          data[2 + half][at] = static_cast<float>(number % kDigit);
          data[4 + half][at] = static_cast<float>(number / kDigit);
        }
      for (std::size_t t = 0; t < data.size(); ++t) textures_[t].upload_level(l, data[t].data());
    }
  }
  void upload_witness() {
    for (int l = 0; l < textures_[0].shape().level_count; ++l) {
      const MipLevelPlace& level = layout_.levels[static_cast<std::size_t>(l)];
      std::vector<float> values;
      for (int i = 0; i < level.width * level.height; ++i)
        for (int c = 0; c < 4; ++c) values.push_back(witness_value(level.offset + i, c));
      textures_[0].upload_level(l, values.data());
    }
  }
  void bind() const {
    for (int i = 0; i < kProbeBuffers; ++i) textures_[static_cast<std::size_t>(i)].bind(i);
  }

 private:
  const MipLayout& layout_;
  std::vector<Texture> textures_;
};

// Returns the rectangle of a band that the object covers. The width is 0 if the object covers nothing.
PixelRectangle covered_part(const FloatImage& place) {
  int left = place.width, right = -1, top = place.height, bottom = -1;
  for (int y = 0, i = 0; y < place.height; ++y)
    for (int x = 0; x < place.width; ++x, ++i)
      if (place.rgba[static_cast<std::size_t>(4 * i + 3)] > 0.5f) {
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = y;
      }
  if (right < 0) return {};
  return {left, top, right - left + 1, bottom - top + 1};
}

// The measurements of the covered part of a band, and the search for the texel of each entry.
class BandDecoder {
 public:
  BandDecoder(const MipLayout& layout, int level_count, const TexelClasses& classes, const TextureMapping& mapping,
              int span)
      : layout_(layout), level_count_(level_count), classes_(classes), mapping_(mapping), span_(span) {}

  PixelRectangle part;
  FloatImage place;    // place of each sub-pixel of the part
  FloatImage witness;  // the witness texture's values there
  std::vector<std::array<FloatImage, kProbeBuffers>> draws;

  bool is_covered(std::size_t i) const { return place.rgba[4 * i + 3] > 0.5f; }

  // Appends the entries of sub-pixel i of the part. Returns false if they do not sum to 1, or do not reproduce the
  // value that GL read from the witness texture.
  bool decode(std::size_t i, std::vector<Entry>& entries) const {
    float sum = 0.0f;
    const std::size_t begin = entries.size();
    for (std::size_t d = 0; d < draws.size(); ++d)
      for (int c = 0; c < kClassesADraw; ++c) {
        const auto at = 4 * i + static_cast<std::size_t>(c % 4);
        const auto half = static_cast<std::size_t>(c / 4);
        const float weight = draws[d][half].rgba[at];
        if (!(std::abs(weight) > 0.0f)) continue;
        const int number = texel_of(weight, draws[d][2 + half].rgba[at], draws[d][4 + half].rgba[at],
                                    static_cast<int>(d) * kClassesADraw + c, i);
        if (number < 0) continue;
        entries.push_back({static_cast<std::uint32_t>(number), weight});
        sum += weight;
      }
    return std::abs(sum - 1.0f) <= kRowSumTolerance && gives_witness(i, entries, begin);
  }

 private:
  bool gives_witness(std::size_t i, const std::vector<Entry>& entries, std::size_t begin) const {
    for (int c = 0; c < 4; ++c) {
      float value = 0.0f;
      for (std::size_t k = begin; k < entries.size(); ++k)
        value += entries[k].weight * witness_value(static_cast<int>(entries[k].texel), c);
      if (!(std::abs(value - witness.rgba[4 * i + static_cast<std::size_t>(c)]) <= kWitnessTolerance)) return false;
    }
    return true;
  }

  int class_of(int texel) const {
    const int l = layout_.level_of(texel);
    const MipLevelPlace& level = layout_.levels[static_cast<std::size_t>(l)];
    const int i = texel - level.offset;
    return classes_.class_of(l, i % level.width, i / level.width);
  }

  int texel_of(float weight, float low, float high, int of_class, std::size_t i) const {
    const float low_digit = low / weight, high_digit = high / weight;
    const float l = std::round(low_digit), h = std::round(high_digit);
    if (std::abs(low_digit - l) < kDigitTolerance && std::abs(high_digit - h) < kDigitTolerance) {
      const int number = static_cast<int>(h) * kDigit + static_cast<int>(l) - 1;
      if (number >= 0 && number < layout_.texel_count && layout_.level_of(number) < level_count_ &&
          class_of(number) == of_class)
        return number;
    }
    return nearest_of_class(of_class, low_digit, high_digit, i);
  }

  // Returns the texel of a class that is nearest to the texture coordinate, in the level that has the class's parity.
  // Among texels at about the same distance, prefers the texel whose number is closest to the digits.
  int nearest_of_class(int of_class, float low_digit, float high_digit, std::size_t i) const {
    const double s = static_cast<double>(place.rgba[4 * i]), t = static_cast<double>(place.rgba[4 * i + 1]);
    const double lod = std::clamp(static_cast<double>(place.rgba[4 * i + 2]), 0.0, level_count_ - 1.0);
    const int finer = static_cast<int>(lod);
    int best = -1;
    double best_gap = std::numeric_limits<double>::max();
    for (int l = finer; l <= std::min(finer + 1, level_count_ - 1); ++l) {
      const MipLevelPlace& level = layout_.levels[static_cast<std::size_t>(l)];
      const double x = s * level.width - 0.5, y = t * level.height - 0.5;
      const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
      for (int dy = -span_; dy <= span_; ++dy)
        for (int dx = -span_; dx <= span_; ++dx) {
          const int tx = wrapped(x0 + dx, level.width, mapping_.wrap_s);
          const int ty = wrapped(y0 + dy, level.height, mapping_.wrap_t);
          if (classes_.class_of(l, tx, ty) != of_class) continue;
          const int texel = level.offset + ty * level.width + tx;
          // The error of the digits is the rounding error divided by the weight. The error of the coordinates is below
          // a hundredth of a texel.
          const double gap = std::max({0.0, std::abs(x - (x0 + dx)) - 1.0, std::abs(y - (y0 + dy)) - 1.0});
          const double digits = std::abs(static_cast<double>((texel + 1) % kDigit) - static_cast<double>(low_digit)) +
                                std::abs(static_cast<double>((texel + 1) / kDigit) - static_cast<double>(high_digit));
          const double cost = std::floor(gap * 100.0) + std::min(0.99, digits * 1e-4);
          if (cost < best_gap) {
            best_gap = cost;
            best = texel;
          }
        }
    }
    return best;
  }

  static int wrapped(int i, int count, WrapMode mode) {
    return mode == WrapMode::kPeriodic ? ((i % count) + count) % count : std::clamp(i, 0, count - 1);
  }

  const MipLayout& layout_;
  int level_count_;
  const TexelClasses& classes_;
  const TextureMapping& mapping_;
  int span_;
};

// Sorts entries by texel, and adds up the entries of each texel.
void merge(std::vector<Entry>& entries) {
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.texel < b.texel; });
  std::size_t end = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (end > 0 && entries[end - 1].texel == entries[i].texel) entries[end - 1].weight += entries[i].weight;
    else entries[end++] = entries[i];
  }
  entries.resize(end);
}

// The matrix rows for one row of pixels.
struct PixelRows {
  std::vector<std::uint32_t> pixels, sizes;
  std::vector<float> coverage;
  std::vector<Entry> entries;
  std::uint64_t rejected = 0;
};

void append(FilterMatrix& matrix, const PixelRows& rows) {
  matrix.rows_rejected += rows.rejected;
  matrix.pixels.insert(matrix.pixels.end(), rows.pixels.begin(), rows.pixels.end());
  matrix.coverage.insert(matrix.coverage.end(), rows.coverage.begin(), rows.coverage.end());
  for (const std::uint32_t size : rows.sizes) matrix.row_begin.push_back(matrix.row_begin.back() + size);
  for (const Entry& entry : rows.entries) {
    matrix.columns.push_back(entry.texel);
    matrix.weights.push_back(entry.weight);
  }
}

// Averages the matrix rows of the sub-pixels that the object covers, for one row of pixels. The mean is the box filter
// over the pixel divided by the coverage (section 3.2, "Inference with antialiasing"). `top` is the band's first row of
// sub-pixels in the picture.
PixelRows decode_pixel_row(const BandDecoder& band, int y, int top, int supersampling, int width) {
  PixelRows rows;
  std::vector<Entry> pixel;
  const int s = supersampling;
  const int first = band.part.x / s, last = (band.part.x + band.part.width - 1) / s;
  for (int x = first; x <= last; ++x) {
    pixel.clear();
    std::uint32_t covered = 0;
    bool is_valid = true;
    for (int sy = 0; sy < s; ++sy)
      for (int sx = 0; sx < s; ++sx) {
        const int px = x * s + sx - band.part.x, py = y * s + sy - top - band.part.y;
        if (px < 0 || py < 0 || px >= band.part.width || py >= band.part.height) continue;
        const auto i =
            static_cast<std::size_t>(py) * static_cast<std::size_t>(band.part.width) + static_cast<std::size_t>(px);
        if (!band.is_covered(i)) continue;
        ++covered;
        is_valid = is_valid && band.decode(i, pixel);
      }
    if (covered > 0 && !is_valid) ++rows.rejected;
    if (covered == 0 || !is_valid) continue;
    merge(pixel);
    for (Entry& entry : pixel) entry.weight /= static_cast<float>(covered);
    rows.pixels.push_back(static_cast<std::uint32_t>(y * width + x));
    rows.coverage.push_back(static_cast<float>(covered) / static_cast<float>(s * s));
    rows.sizes.push_back(static_cast<std::uint32_t>(pixel.size()));
    rows.entries.insert(rows.entries.end(), pixel.begin(), pixel.end());
  }
  return rows;
}

}  // namespace

int band_row_count(int sub_width, int sub_height, int supersampling) {
  constexpr std::size_t kBytesMax = std::size_t{256} << 20;
  constexpr std::size_t kPixelBytes = 4 * sizeof(float) * (kProbeBuffers + 1) + sizeof(float);
  const auto rows = static_cast<int>(kBytesMax / (kPixelBytes * static_cast<std::size_t>(sub_width)));
  const int unit = 2 * supersampling;  // whole pixels, and whole groups of 2 x 2 fragments
  return std::min(sub_height, std::max(unit, rows / unit * unit));
}

FilterProbe::FilterProbe(const GlFunctions& gl, int width, int height, int supersampling)
    : gl_(gl),
      width_(width),
      height_(height),
      supersampling_(supersampling),
      framebuffer_(gl, width * supersampling,
                   band_row_count(width * supersampling, height * supersampling, supersampling), kProbeBuffers + 1),
      probe_(gl, probe_sources({})),
      occluder_(gl, probe_sources({"MULTUM_OCCLUDER"})) {}

// Values that do not change when classes are made wider.
struct FilterProbe::Pass {
  const std::vector<PlacedMesh>& objects;
  std::size_t object;
  const TextureMapping& mapping;
  const MipLayout& layout;
  int level_count;
  ProbeTextures& textures;
  int threads;
};

FilterMatrix FilterProbe::probe(const std::vector<PlacedMesh>& objects, std::size_t object,
                                const TextureMapping& mapping, const ProbeSampler& sampler, int threads) const {
  const MipLayout layout(mapping.width, mapping.height);
  const int level_count = sampler.has_mips ? layout.level_count() : 1;
  ProbeTextures textures(gl_, layout, {mapping.width, mapping.height, level_count, TexelFormat::kRgba32f},
                         {mapping.wrap_s, mapping.wrap_t, true, sampler.anisotropy});
  probe_.set_units("u_probes", 0, kProbeBuffers);
  const Pass pass{objects, object, mapping, layout, level_count, textures, threads};
  FilterMatrix matrix;
  for (int span = first_span(sampler);; span = std::min(last_span(sampler), span + span / 2)) {
    matrix = probe_with_span(pass, span);
    if (matrix.rows_rejected <= matrix.row_count() / 1000 || span == last_span(sampler)) break;
  }
  matrix.anisotropy = sampler.anisotropy;
  matrix.has_mips = sampler.has_mips;
  return matrix;
}

void FilterProbe::draw_band(const Pass& pass, int bottom_row) const {
  framebuffer_.bind_rows(bottom_row, height_ * supersampling_);
  framebuffer_.clear_colour();
  framebuffer_.clear_depth();
  gl_.Enable(GL_DEPTH_TEST);
  for (std::size_t i = 0; i < pass.objects.size(); ++i) {
    if (i == pass.object) continue;
    occluder_.use();
    occluder_.set_mat4("u_object_to_clip", glm::value_ptr(pass.objects[i].object_to_clip));
    pass.objects[i].mesh->draw();
  }
  probe_.use();
  probe_.set_mat4("u_object_to_clip", glm::value_ptr(pass.objects[pass.object].object_to_clip));
  pass.textures.bind();
  pass.objects[pass.object].mesh->draw();
  check_gl(gl_, "drawing the filter probe");
}

FilterMatrix FilterProbe::probe_with_span(const Pass& pass, int span) const {
  FilterMatrix matrix;
  matrix.width = width_;
  matrix.height = height_;
  matrix.supersampling = supersampling_;
  matrix.texture_width = pass.mapping.width;
  matrix.texture_height = pass.mapping.height;
  matrix.wrap_s = pass.mapping.wrap_s;
  matrix.wrap_t = pass.mapping.wrap_t;
  matrix.row_begin = {0};
  const TexelClasses classes(pass.layout, pass.level_count, span);
  const int draw_count = (classes.class_count() + kClassesADraw - 1) / kClassesADraw;
  const int sub_height = height_ * supersampling_, band_height = framebuffer_.height();
  // Bands are counted from below, but the rows of the matrix are counted from above.
  for (int bottom = (sub_height - 1) / band_height * band_height; bottom >= 0; bottom -= band_height) {
    BandDecoder band(pass.layout, pass.level_count, classes, pass.mapping, span);
    const int top = sub_height - bottom - band_height;  // if negative, the buffer's first rows are outside the picture
    const int hidden = std::max(0, -top);
    pass.textures.upload_witness();
    draw_band(pass, bottom);
    band.part = covered_part(framebuffer_.read(kProbeBuffers, {0, hidden, framebuffer_.width(), band_height - hidden}));
    if (band.part.width == 0) continue;
    band.part.y += hidden;
    band.place = framebuffer_.read(kProbeBuffers, band.part);
    band.witness = framebuffer_.read(0, band.part);
    for (int d = 0; d < draw_count; ++d) {
      pass.textures.upload(classes, d * kClassesADraw);
      draw_band(pass, bottom);
      auto& images = band.draws.emplace_back();
      for (int b = 0; b < kProbeBuffers; ++b) images[static_cast<std::size_t>(b)] = framebuffer_.read(b, band.part);
    }
    const int first = (top + band.part.y) / supersampling_;
    const int last = (top + band.part.y + band.part.height - 1) / supersampling_;
    std::vector<PixelRows> rows(static_cast<std::size_t>(last - first + 1));
    for_each_item(static_cast<int>(rows.size()), pass.threads, [&](int i) {
      rows[static_cast<std::size_t>(i)] = decode_pixel_row(band, first + i, top, supersampling_, width_);
    });
    for (const PixelRows& one : rows) append(matrix, one);
  }
  return matrix;
}

}  // namespace multum::gl
