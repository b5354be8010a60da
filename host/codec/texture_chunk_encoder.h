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

#include "host/codec/decoder/texture_chunk.h"
#include "host/codec/image_transforms.h"

namespace multum {

struct ChunkSource {
  std::size_t width = 1, height = 1;
  std::vector<std::size_t> sizes;  // samples along each dimension, the last runs fastest
  /// Of each sample, [height][width][3]: gamma-coded values, 255 for a radiance of 1.
  std::vector<std::vector<float>> textures;
  /// What the square of a texel's error weighs, summed over the samples, at least 0: for the choice of colour axes.
  std::vector<float> texel_weights;
  /// What the square of an error of each coefficient weighs in one sample, at least 0: cosines [block][v][u], wavelets
  /// [height][width]. Called once for each sample and level.
  std::function<std::vector<float>(std::size_t sample)> coefficient_weights;
  /// Coefficients of all textures in planes; none: HostImageTransforms makes them, anew for every chunk.
  std::function<std::vector<PlaneCoefficients>(const PlaneAxes& axes)> coefficients = {};
};

struct ChunkSettings {
  ImageCoder coder = ImageCoder::kDct;
  std::size_t side = 16;  // of cosine blocks: 8, 16 or 32
  /// The pyramid's, as ParameterPyramid::of has them. None: a basis of at most `basis_images` images is learnt from the
  /// block instead (Karhunen-Loeve transform over the samples).
  std::vector<ParameterPyramid::Halvings> levels;
  std::size_t basis_images = 8;
  bool linear = false;
  double lambda = 1.0;  // weighed squared error that one bit is worth, above 0
};

struct EncodedChunk {
  std::vector<std::uint8_t> bytes;
  /// What is left of the source, squared and weighed, summed over coefficients and samples.
  double error = 0.0;

  double cost(double lambda) const { return error + 8.0 * lambda * static_cast<double>(bytes.size()); }
};

/// Stops the program where source and settings contradict one another.
EncodedChunk encode_chunk(const ChunkSource& source, const ChunkSettings& settings);

}  // namespace multum
