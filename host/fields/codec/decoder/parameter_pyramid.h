// SPDX-License-Identifier: Apache-2.0
// Defines the adaptive Laplacian pyramid over a block of parameter space (Hakura et al. 2000, section 4, figure 8): its
// images, and which images add up to each sample. A level halves some dimensions of the next finer level, each of them
// any number of times. Dimensions can thus be halved in any order, and levels can be left out. Any number of dimensions
// and any sizes are allowed. For example, halving 5 samples gives 3 cells, and the last cell covers only one sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace multum {

class ParameterPyramid {
 public:
  static constexpr std::size_t kDimensionsMax = 8, kLevelsMax = 32, kSamplesMax = 65536;

  /// The number of halvings per dimension.
  using Halvings = std::vector<std::uint8_t>;

  /// An image and its share in a sample.
  struct Term {
    std::size_t image;
    float weight;
  };

  /// `sizes` has the number of samples along each dimension, with a product of 1 to kSamplesMax. `levels` starts with
  /// the coarsest level, and the last level halves nothing. Compared with the previous level, each level halves at
  /// least one dimension fewer times and no dimension more times. Returns nullopt if the levels break these rules.
  static std::optional<ParameterPyramid> of(std::vector<std::size_t> sizes, std::vector<Halvings> levels);

  std::size_t level_count() const { return levels_.size(); }
  std::size_t sample_count() const { return sample_count_; }
  std::size_t image_count() const { return first_image_.back(); }
  const std::vector<std::size_t>& sizes() const { return sizes_; }
  const std::vector<Halvings>& levels() const { return levels_; }

  /// Returns the number of a level's first image. Images are numbered level by level, starting with the coarsest.
  /// Within a level, images are in the order of samples, in which the last dimension changes fastest.
  std::size_t first_image(std::size_t level) const { return first_image_[level]; }
  std::size_t level_of(std::size_t image) const;
  /// Returns the image of a level whose cell contains the sample.
  std::size_t image_of(std::size_t level, std::size_t sample) const;
  /// Returns the image of the next coarser level whose cell contains this image's cell, or nullopt for the coarsest
  /// level.
  std::optional<std::size_t> parent_of(std::size_t image) const;
  /// Returns the samples in the image's cell, in ascending order.
  std::vector<std::size_t> samples_of(std::size_t image) const;

  /// Returns the level's images that add up to the sample. Without `linear`, returns the nearest image. With `linear`,
  /// returns the images whose cell centres surround the sample in each dimension. Beyond the outermost centres, returns
  /// only the outermost image. The weights sum to 1.
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
