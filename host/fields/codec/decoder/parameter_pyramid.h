// SPDX-License-Identifier: Apache-2.0
// The adaptive Laplacian pyramid over a block of parameter space (Hakura et al. 2000, section 4, figure 8): which
// images there are, and which of them add up to a sample. A level halves some dimensions of the next finer one, each as
// often as it likes, so dimensions may be halved in any order, and levels be left out. Any number of dimensions and
// sizes: of 5 samples, halved, 3 are left, the last of them for one sample alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace multum {

class ParameterPyramid {
 public:
  static constexpr std::size_t kDimensionsMax = 8, kLevelsMax = 32, kSamplesMax = 65536;

  /// How often each dimension is halved.
  using Halvings = std::vector<std::uint8_t>;

  /// An image and its share in a sample.
  struct Term {
    std::size_t image;
    float weight;
  };

  /// `sizes`: samples along each dimension, 1 to kSamplesMax in all. `levels`: the coarsest first, each halving no
  /// dimension more than the one before and some dimension less; the last halves none. Nothing where that does not
  /// hold.
  static std::optional<ParameterPyramid> of(std::vector<std::size_t> sizes, std::vector<Halvings> levels);

  std::size_t level_count() const { return levels_.size(); }
  std::size_t sample_count() const { return sample_count_; }
  std::size_t image_count() const { return first_image_.back(); }
  const std::vector<std::size_t>& sizes() const { return sizes_; }
  const std::vector<Halvings>& levels() const { return levels_; }

  /// Images are numbered level by level, the coarsest first; within a level the last dimension runs fastest, as
  /// samples.
  std::size_t first_image(std::size_t level) const { return first_image_[level]; }
  std::size_t level_of(std::size_t image) const;
  /// Of the level, that whose cell the sample lies in.
  std::size_t image_of(std::size_t level, std::size_t sample) const;
  /// Of the next coarser level, that whose cell the image's lies in; none for the coarsest.
  std::optional<std::size_t> parent_of(std::size_t image) const;
  /// Samples in the image's cell, rising.
  std::vector<std::size_t> samples_of(std::size_t image) const;

  /// What adds up to the sample from the level: the nearest image, or the images between whose cells' middles it lies
  /// (linear in each dimension; beyond the outermost middles the outermost alone). Weights sum to 1.
  std::vector<Term> terms(std::size_t level, std::size_t sample, bool linear) const;

 private:
  std::vector<std::size_t> indices_of(std::size_t sample) const;
  std::size_t cells(std::size_t level, std::size_t dimension) const;

  std::vector<std::size_t> sizes_;
  std::vector<Halvings> levels_;
  std::vector<std::size_t> first_image_;  // [levels + 1]
  std::size_t sample_count_ = 1;
};

}  // namespace multum
