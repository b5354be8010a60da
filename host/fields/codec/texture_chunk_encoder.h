// SPDX-License-Identifier: Apache-2.0
// Encodes the textures of one layer of an object over one block of parameters as a texture chunk (Hakura et al. 2000,
// section 4): an adaptive Laplacian pyramid over the parameters, each of its images coded in two dimensions.
//
// Departures from the paper. The loop is closed: an image is the weighted mean of what its samples still lack after the
// coarser images as the decoder will have them, so that quantization errors of coarser images are not lost. Errors
// weigh what they weigh in drawn pixels, coefficient by coefficient. Steps and the choice of coefficients follow from
// one Lagrange multiplier, so that all images of all chunks coded with it have equal slopes of error over bits.
#pragma once

#include <functional>
#include <optional>

#include "host/fields/codec/colour_axes.h"
#include "host/fields/codec/decoder/texture_chunk.h"
#include "host/fields/codec/image_transforms.h"

namespace multum {

struct ChunkSource {
  std::size_t width = 1, height = 1;
  std::vector<std::size_t> sizes;  // samples along each dimension, the last runs fastest
  /// Of each sample, [height][width][3]: gamma-coded values, 255 for a radiance of 1.
  std::vector<std::vector<float>> textures;
  /// What the square of a texel's error weighs, summed over the samples, at least 0: for the choice of colour axes.
  std::vector<float> texel_weights;
  /// Makes coefficients of the textures, all of them together; null: HostImageTransforms.
  ImageTransforms* transforms = nullptr;
};

/// What the square of an error of each coefficient weighs in one sample, at least 0: cosines [block][v][u], wavelets
/// [height][width]. Called once for each sample.
using CoefficientWeights = std::function<std::vector<float>(std::size_t sample)>;

struct ChunkSettings {
  ImageCoder coder = ImageCoder::kDct;
  std::size_t side = 16;  // of cosine blocks: 8, 16 or 32
  /// The pyramid's, as ParameterPyramid::of has them. None: a basis of at most `basis_images` images is learnt from the
  /// block instead (Karhunen-Loeve transform over the samples).
  std::vector<ParameterPyramid::Halvings> levels;
  std::size_t basis_images = 8;
  bool linear = false;
  /// Images are of what the coarser ones were to be, not of what they have become: as the paper has it.
  bool open_loop = false;
  double lambda = 1.0;  // weighed squared error that one bit is worth, above 0
};

struct EncodedChunk {
  std::vector<std::uint8_t> bytes;
  /// What is left of the source, squared and weighed, summed over coefficients and samples.
  double error = 0.0;

  double cost(double lambda) const { return error + 8.0 * lambda * static_cast<double>(bytes.size()); }
};

/// What all ways to code a chunk by one image coder share: its textures in that coder's coefficients, and what those
/// weigh. Not for two threads at once.
class ChunkEncoder {
 public:
  /// `side`: of cosine blocks. The source must outlive the encoder.
  ChunkEncoder(const ChunkSource& source, const CoefficientWeights& weights, ImageCoder coder, std::size_t side);

  /// Stops the program where source and settings contradict one another. `step` is called before each image, and may
  /// throw.
  EncodedChunk encode(const ChunkSettings& settings, const std::function<void()>& step);

 private:
  const std::vector<std::vector<double>>& eigenvectors();

  const ChunkSource& source_;
  TextureChunkFormat format_;                                       // of all ways: without levels
  std::vector<PlaneCoefficients> coefficients_;                     // of each sample
  std::vector<std::vector<float>> weights_;                         // [sample][coefficient]
  std::vector<float> summed_weights_;                               // [coefficient]
  std::optional<std::vector<std::vector<double>>> eigenvectors_{};  // made when first asked for
};

}  // namespace multum
