// SPDX-License-Identifier: Apache-2.0
// Encodes the textures of one layer of an object over one block of parameters as a texture chunk (Hakura et al. 2000,
// section 4). The chunk is an adaptive Laplacian pyramid over the parameters, whose images are coded in two dimensions.
//
// Departures from the paper: The coder is a closed loop. An image is the weighted mean of the differences between its
// samples and the sum of the decoded coarser images. Finer images thus correct quantization errors of coarser images.
// The errors of each coefficient are weighted by its visibility in drawn pixels. Steps and the choice of coefficients
// follow from one Lagrange multiplier. With this one multiplier, all images of all chunks have the same slope of error
// over bits.
#pragma once

#include <functional>
#include <optional>

#include "host/fields/codec/colour_axes.h"
#include "host/fields/codec/decoder/texture_chunk.h"
#include "host/fields/codec/image_transforms.h"

namespace multum {

struct ChunkSource {
  std::size_t width = 1, height = 1;
  std::vector<std::size_t> sizes;  // samples along each dimension; the last changes fastest
  /// One texture per sample, [height][width][3]. The values are gamma-coded, and 255 is a radiance of 1.
  std::vector<std::vector<float>> textures;
  /// The weight of each texel's squared error, summed over the samples, at least 0. The weights are used to choose
  /// colour axes.
  std::vector<float> texel_weights;
  /// Computes the coefficients of all textures together. If null, HostImageTransforms does this.
  ImageTransforms* transforms = nullptr;
};

/// Returns the weight of each coefficient's squared error in one sample, at least 0. Cosines are [block][v][u], and
/// wavelets are [height][width]. This function is called once per sample.
using CoefficientWeights = std::function<std::vector<float>(std::size_t sample)>;

struct ChunkSettings {
  ImageCoder coder = ImageCoder::kDct;
  std::size_t side = 16;  // side of cosine blocks: 8, 16 or 32
  /// The levels of the pyramid, as in ParameterPyramid::of. If empty, a basis of at most `basis_images` images is
  /// learnt from the block instead (Karhunen-Loeve transform over the samples).
  std::vector<ParameterPyramid::Halvings> levels;
  std::size_t basis_images = 8;
  bool linear = false;
  /// If set, finer images refine the exact coarser images instead of the decoded ones, as in the paper.
  bool open_loop = false;
  double lambda = 1.0;  // the weighted squared error that justifies one bit, above 0
};

struct EncodedChunk {
  std::vector<std::uint8_t> bytes;
  /// The remaining squared error, weighted and summed over coefficients and samples.
  double error = 0.0;

  double cost(double lambda) const { return error + 8.0 * lambda * static_cast<double>(bytes.size()); }
};

/// The coefficients of a chunk's textures and their weights. All codings of the chunk with one image coder share them.
/// Two threads must not use one object at once.
class ChunkEncoder {
 public:
  /// `side` is the side of cosine blocks. The source must outlive the encoder.
  ChunkEncoder(const ChunkSource& source, const CoefficientWeights& weights, ImageCoder coder, std::size_t side);

  /// Ends the program if the source and the settings contradict each other. Calls `step` before each image. `step` may
  /// throw.
  EncodedChunk encode(const ChunkSettings& settings, const std::function<void()>& step);

 private:
  const std::vector<std::vector<double>>& eigenvectors();

  const ChunkSource& source_;
  TextureChunkFormat format_;                                       // the fields that all codings share, without levels
  std::vector<PlaneCoefficients> coefficients_;                     // coefficients by sample
  std::vector<std::vector<float>> weights_;                         // [sample][coefficient]
  std::vector<float> summed_weights_;                               // [coefficient]
  std::optional<std::vector<std::vector<double>>> eigenvectors_{};  // computed on first use
};

}  // namespace multum
