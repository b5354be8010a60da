// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/drawn_weights.h"

#include <algorithm>
#include <cmath>

#include "host/fields/codec/decoder/block_dct.h"
#include "host/fields/codec/decoder/dct_stream_decoder.h"
#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/decoder/wavelet_transform.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

/// Multiplies a texture by the filter matrix A. The texture has three channels per texel: [row][3].
std::vector<float> drawn(const FilterMatrix& matrix, const std::vector<float>& texels) {
  std::vector<float> pixels(3 * matrix.row_count());
  for (std::size_t r = 0; r < matrix.row_count(); ++r)
    for (std::uint32_t e = matrix.row_begin[r]; e < matrix.row_begin[r + 1]; ++e)
      for (std::size_t c = 0; c < 3; ++c)
        pixels[3 * r + c] += matrix.weights[e] * texels[3 * std::size_t{matrix.columns[e]} + c];
  return pixels;
}

/// Multiplies the pixels by A^T and adds up all mip levels in the finest level. The result is [height][width][3].
std::vector<float> handed_back(const FilterMatrix& matrix, const std::vector<float>& pixels) {
  const auto width = static_cast<std::size_t>(matrix.texture_width);
  const auto height = static_cast<std::size_t>(matrix.texture_height);
  std::vector<float> texels(3 * mip_texel_count(width, height));
  for (std::size_t r = 0; r < matrix.row_count(); ++r)
    for (std::uint32_t e = matrix.row_begin[r]; e < matrix.row_begin[r + 1]; ++e)
      for (std::size_t c = 0; c < 3; ++c)
        texels[3 * std::size_t{matrix.columns[e]} + c] += matrix.weights[e] * pixels[3 * r + c];
  return handed_down(width, height, 3, std::move(texels));
}

/// The coefficients that are probed at once. They are either at one position of all cosine blocks, or in one band.
class Probe {
 public:
  explicit Probe(const CoefficientLayout& layout) : layout_(layout), grid_{layout.width, layout.height, layout.side} {
    if (layout.coder == ImageCoder::kWavelet) bands_ = wavelet_bands(layout.width, layout.height);
  }

  bool is_dct() const { return layout_.coder == ImageCoder::kDct; }
  std::size_t kinds() const { return is_dct() ? grid_.side * grid_.side : bands_.size(); }
  std::size_t coefficients() const { return is_dct() ? grid_.count() * kinds() : layout_.width * layout_.height; }
  const BlockGrid& grid() const { return grid_; }
  const std::vector<WaveletBand>& bands() const { return bands_; }

  /// Returns the sum of the kind's basis images with random signs, [height][width].
  std::vector<float> image(std::size_t kind, SplitMix64& random) const {
    std::vector<float> samples(layout_.width * layout_.height);
    const auto sign = [&random] { return random.next() >> 63 != 0 ? 1.0f : -1.0f; };
    if (is_dct()) {
      std::vector<float> basis(kinds());
      basis[kind] = 1.0f;
      inverse_dct(static_cast<int>(grid_.side), basis, basis);
      for (std::size_t number = 0; number < grid_.count(); ++number) {
        const float s = sign();
        over_block(number, [&](std::size_t texel, std::size_t place) { samples[texel] = s * basis[place]; });
      }
      return samples;
    }
    const WaveletBand& band = bands_[kind];
    for (std::size_t y = band.y; y < band.y + band.height; ++y)
      for (std::size_t x = band.x; x < band.x + band.width; ++x) samples[y * layout_.width + x] = sign();
    inverse_wavelet(layout_.width, layout_.height, samples);
    return samples;
  }

  /// Adds texel values to the coefficients of this kind at the same places. `stride` and `offset` select the texel
  /// values.
  void collect(std::size_t kind, const std::vector<float>& texels, std::size_t channel,
               std::vector<float>& energies) const {
    if (is_dct()) {
      for (std::size_t number = 0; number < grid_.count(); ++number)
        over_block(number, [&](std::size_t texel, std::size_t) {
          energies[number * kinds() + kind] += texels[3 * texel + channel];
        });
      return;
    }
    const WaveletBand& band = bands_[kind];
    for (std::size_t y = 0; y < layout_.height; ++y)
      for (std::size_t x = 0; x < layout_.width; ++x) {
        const std::size_t bx = std::min(x >> band.depth, band.width - 1),
                          by = std::min(y >> band.depth, band.height - 1);
        energies[(band.y + by) * layout_.width + band.x + bx] += texels[3 * (y * layout_.width + x) + channel];
      }
  }

 private:
  template <class Visit>
  void over_block(std::size_t number, Visit visit) const {
    const std::size_t left = number % grid_.columns() * grid_.side, top = number / grid_.columns() * grid_.side;
    for (std::size_t y = 0; y < std::min(grid_.side, layout_.height - top); ++y)
      for (std::size_t x = 0; x < std::min(grid_.side, layout_.width - left); ++x)
        visit((top + y) * layout_.width + left + x, y * grid_.side + x);
  }

  CoefficientLayout layout_;
  BlockGrid grid_;
  std::vector<WaveletBand> bands_;
};

/// The weight of each wavelet is raised to at least this share of the largest neighbouring weight, because wavelets
/// extend beyond their places. Without this, details at the borders of visible areas are lost, and the error of
/// field_demo1 at a ratio of 370:1 is 1.5 times as large.
void raise_beside_seen(const Probe& probe, std::size_t width, std::vector<float>& energies) {
  constexpr float kShare = 0.3f;
  const std::vector<float> before = energies;
  for (const WaveletBand& band : probe.bands())
    for (std::size_t y = 0; y < band.height; ++y)
      for (std::size_t x = 0; x < band.width; ++x) {
        float most = 0.0f;
        for (std::size_t ny = y > 0 ? y - 1 : 0; ny < std::min(y + 2, band.height); ++ny)
          for (std::size_t nx = x > 0 ? x - 1 : 0; nx < std::min(x + 2, band.width); ++nx)
            most = std::max(most, before[(band.y + ny) * width + band.x + nx]);
        float& energy = energies[(band.y + y) * width + band.x + x];
        energy = std::max(energy, kShare * most);
      }
}

}  // namespace

std::vector<float> texel_masses(const FilterMatrix& matrix) {
  const auto texels = handed_back(matrix, std::vector<float>(3 * matrix.row_count(), 1.0f));
  std::vector<float> masses(texels.size() / 3);
  for (std::size_t i = 0; i < masses.size(); ++i) masses[i] = texels[3 * i];
  return masses;
}

/// Splits each block into sixteen parts, and returns the fourth root of the ratio of the greatest mass to the mean
/// mass. On field_demo1 this correction lowers error + lambda bits by 0.5 %. A square root instead of the fourth root
/// has about the same effect.
std::vector<float> partly_seen_factors(const CoefficientLayout& layout, const std::vector<float>& masses) {
  constexpr float kExponent = 0.25f, kShareMin = 0.02f;
  const BlockGrid grid{layout.width, layout.height, layout.side};
  const std::size_t part = grid.side / 4;
  std::vector<float> sums(16 * grid.count()), factors;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const std::size_t x = i % layout.width, y = i / layout.width;
    const std::size_t number = y / grid.side * grid.columns() + x / grid.side;
    sums[16 * number + y % grid.side / part * 4 + x % grid.side / part] += masses[i];
  }
  for (auto begin = sums.begin(); begin != sums.end(); begin += 16) {
    const float most = *std::max_element(begin, begin + 16);
    float mean = 0.0f;
    for (auto part_sum = begin; part_sum != begin + 16; ++part_sum) mean += *part_sum / 16.0f;
    factors.push_back(most > 0.0f ? std::pow(1.0f / std::max(mean / most, kShareMin), kExponent) : 1.0f);
  }
  return factors;
}

std::vector<std::vector<float>> coefficient_energies(const std::vector<FilterMatrix>& matrices,
                                                     const CoefficientLayout& layout) {
  const Probe probe(layout);
  std::vector<std::vector<float>> energies(matrices.size(), std::vector<float>(probe.coefficients()));
  SplitMix64 random(1);
  // Wavelets overlap, so a single choice of signs measures their weights with an error of up to a third.
  const std::size_t rounds = probe.is_dct() ? 1 : 4;
  for (std::size_t kind = 0; kind < rounds * probe.kinds(); kind += 3) {  // three kinds at once: red, green, blue
    const std::size_t count = std::min<std::size_t>(3, rounds * probe.kinds() - kind);
    std::vector<float> finest(3 * layout.width * layout.height);
    for (std::size_t c = 0; c < count; ++c) {
      const auto image = probe.image((kind + c) % probe.kinds(), random);
      for (std::size_t i = 0; i < image.size(); ++i) finest[3 * i + c] = image[i];
    }
    const std::vector<float> levels = mip_levels(layout.width, layout.height, finest);
    for (std::size_t m = 0; m < matrices.size(); ++m) {
      auto pixels = drawn(matrices[m], levels);
      for (float& value : pixels) value *= value;
      const auto texels = handed_back(matrices[m], pixels);
      for (std::size_t c = 0; c < count; ++c) probe.collect((kind + c) % probe.kinds(), texels, c, energies[m]);
    }
  }
  for (std::size_t m = 0; m < matrices.size(); ++m) {
    for (float& energy : energies[m]) energy /= static_cast<float>(rounds);
    if (!probe.is_dct()) {
      raise_beside_seen(probe, layout.width, energies[m]);
      continue;
    }
    const std::vector<float> factors = partly_seen_factors(layout, texel_masses(matrices[m]));
    for (std::size_t i = 0; i < energies[m].size(); ++i) energies[m][i] *= factors[i / probe.kinds()];
  }
  return energies;
}

std::vector<std::vector<float>> layer_shares(const FilterMatrix& matrix,
                                             const std::vector<const std::vector<float>*>& layers) {
  constexpr float kExponent = 2.0f - 2.0f / 2.2f;
  constexpr float kRadianceMin = 3e-4f;  // gamma-coded value 6 of 255, below which the gamma curve's slope is
                                         // unreliable
  constexpr float kShareMin = 0.01f;
  std::vector<std::vector<float>> pictures;
  std::vector<float> sum(3 * matrix.row_count());
  for (const auto* layer : layers) {
    pictures.push_back(drawn(matrix, *layer));
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += pictures.back()[i];
  }
  const auto width = static_cast<std::size_t>(matrix.texture_width);
  const auto columns = (width + kShareCell - 1) / kShareCell;
  const auto rows = (static_cast<std::size_t>(matrix.texture_height) + kShareCell - 1) / kShareCell;
  std::vector<std::vector<float>> shares;
  for (const auto& picture : pictures) {
    std::vector<float> pixels(sum.size());  // channels: visible share, the constant 1, and an unused one
    for (std::size_t r = 0; r < matrix.row_count(); ++r) {
      float shown = 0.0f;
      for (std::size_t c = 0; c < 3; ++c) {
        const float all = std::max(sum[3 * r + c], kRadianceMin), own = std::clamp(picture[3 * r + c], 0.0f, all);
        shown += std::pow(std::max(own / all, 1e-6f), kExponent) / 3.0f;
      }
      pixels[3 * r] = shown * matrix.coverage[r] * matrix.coverage[r];
      pixels[3 * r + 1] = 1.0f;
    }
    const auto texels = handed_back(matrix, pixels);
    std::vector<float> shown(columns * rows), seen(columns * rows);
    for (std::size_t i = 0; 3 * i < texels.size(); ++i) {
      const std::size_t cell = i / width / kShareCell * columns + i % width / kShareCell;
      shown[cell] += texels[3 * i];
      seen[cell] += texels[3 * i + 1];
    }
    float all_shown = 0.0f, all_seen = 0.0f;
    for (std::size_t k = 0; k < seen.size(); ++k) {
      all_shown += shown[k];
      all_seen += seen[k];
    }
    for (std::size_t k = 0; k < seen.size(); ++k)
      shown[k] = seen[k] > kShareMin ? shown[k] / seen[k] : all_seen > 0.0f ? all_shown / all_seen : 0.0f;
    shares.push_back(std::move(shown));
  }
  return shares;
}

std::vector<std::uint32_t> cells_of_coefficients(const CoefficientLayout& layout) {
  const std::size_t columns = (layout.width + kShareCell - 1) / kShareCell;
  const auto cell = [&](std::size_t x, std::size_t y) {
    return static_cast<std::uint32_t>(std::min(y, layout.height - 1) / kShareCell * columns +
                                      std::min(x, layout.width - 1) / kShareCell);
  };
  std::vector<std::uint32_t> cells;
  if (layout.coder == ImageCoder::kDct) {
    const BlockGrid grid{layout.width, layout.height, layout.side};
    for (std::size_t number = 0; number < grid.count(); ++number)
      cells.insert(cells.end(), grid.side * grid.side,
                   cell(number % grid.columns() * grid.side + grid.side / 2 - 1,
                        number / grid.columns() * grid.side + grid.side / 2 - 1));
    return cells;
  }
  cells.resize(layout.width * layout.height);
  for (const WaveletBand& band : wavelet_bands(layout.width, layout.height))
    for (std::size_t y = 0; y < band.height; ++y)
      for (std::size_t x = 0; x < band.width; ++x)
        cells[(band.y + y) * layout.width + band.x + x] =
            cell((2 * x + 1) << band.depth >> 1, (2 * y + 1) << band.depth >> 1);
  return cells;
}

std::vector<float> cell_sums(std::size_t width, const std::vector<float>& texels) {
  const std::size_t columns = (width + kShareCell - 1) / kShareCell, height = texels.size() / width;
  std::vector<float> sums(columns * ((height + kShareCell - 1) / kShareCell));
  for (std::size_t i = 0; i < texels.size(); ++i)
    sums[i / width / kShareCell * columns + i % width / kShareCell] += texels[i];
  return sums;
}

}  // namespace multum
