// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/texture_chunk_encoder.h"

#include <bit>
#include <cmath>
#include <optional>

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/dct_stream_encoder.h"
#include "host/fields/codec/symmetric_eigenvectors.h"
#include "host/fields/codec/wavelet_stream_encoder.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

/// The steps, in units of sqrt(lambda / weight). Theory gives 2.9 at high rates, where one more bit per coefficient
/// divides the error step^2 / 12 by four. On field_demo1, these values had the least error + lambda bits. The values 2,
/// 2.5, 2.8 and 3 were tried for cosines, and 2, 3.5 and 4.5 for wavelets. Wavelet coefficients become zero below a
/// whole step, and cosine coefficients below half a step.
constexpr double kDctStep = 2.8, kWaveletStep = 3.5;
/// High frequencies are hardly visible and get coarser steps. The weight of a high frequency counts as at least this
/// fraction of the first frequency's weight. The first step is the finest.
constexpr double kWeightRatioMin = 1.0 / 60.0;
constexpr float kOffsetUnit = 1.0f / 64.0f;

std::uint8_t code_of(double factor, int zero) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(8.0 * std::log2(factor)) + zero, 0l, 255l));
}

/// Computes the mean of the values, with each value as its own weight. Clearly visible parts then matter most.
class SelfWeighedMean {
 public:
  void add(double value) {
    sum_ += value * value;
    weight_ += value;
  }
  double value() const { return weight_ > 0.0 ? sum_ / weight_ : 0.0; }

 private:
  double sum_ = 0.0, weight_ = 0.0;
};

/// The parts of a coder that encode_chunk needs, for cosines and for wavelets.
class ImageCoding {
 public:
  ImageCoding() = default;
  ImageCoding(const ImageCoding&) = delete;
  ImageCoding& operator=(const ImageCoding&) = delete;
  virtual ~ImageCoding() = default;
  /// Codes an image and returns the decoded coefficients of each plane.
  virtual std::array<std::vector<float>, 3> add(std::array<std::vector<float>, 3> wanted, std::vector<float> weights,
                                                std::optional<std::size_t> parent, std::size_t level, float scale) = 0;
  virtual std::vector<std::uint8_t> finish() = 0;
};

class DctCoding : public ImageCoding {
 public:
  DctCoding(const TextureChunkFormat& format, float lambda)
      : grid_{format.width, format.height, format.side}, steps_(format.steps()), lambda_(lambda), encoder_(grid_) {}

  std::array<std::vector<float>, 3> add(std::array<std::vector<float>, 3> wanted, std::vector<float> weights,
                                        std::optional<std::size_t> parent, std::size_t level, float scale) override {
    const DctTarget target{std::move(wanted), std::move(weights), steps_, scale, lambda_};
    const CoefficientBlocks* before = images_.empty() ? nullptr : &images_.back();
    CoefficientBlocks image = encoder_.add_image(target, parent ? &images_[*parent] : nullptr, before, level);
    images_.push_back(std::move(image));
    std::array<std::vector<float>, 3> decoded;
    for (std::size_t p = 0; p < 3; ++p) {
      decoded[p].resize(target.weights.size());
      for (std::size_t number = 0; number < grid_.count(); ++number) {
        const auto block = images_.back().block(p, number);
        for (std::size_t i = 0; i < block.size(); ++i)
          decoded[p][number * block.size() + i] = scale * steps_[i] * static_cast<float>(block[i]);
      }
    }
    return decoded;
  }

  std::vector<std::uint8_t> finish() override { return encoder_.finish(); }

 private:
  BlockGrid grid_;
  std::vector<float> steps_;
  float lambda_;
  DctStreamEncoder encoder_;
  std::vector<CoefficientBlocks> images_;
};

class WaveletCoding : public ImageCoding {
 public:
  WaveletCoding(const TextureChunkFormat& format, float lambda)
      : width_(format.width),
        height_(format.height),
        steps_(format.steps()),
        lambda_(lambda),
        encoder_(width_, height_) {}

  std::array<std::vector<float>, 3> add(std::array<std::vector<float>, 3> wanted, std::vector<float> weights,
                                        std::optional<std::size_t> parent, std::size_t, float scale) override {
    const WaveletTarget target{std::move(wanted), std::move(weights), steps_, scale, lambda_};
    images_.push_back(encoder_.add_image(target, parent ? &images_[*parent] : nullptr));
    std::array<std::vector<float>, 3> decoded;
    for (std::size_t p = 0; p < 3; ++p) decoded[p] = dequantized(images_.back()[p], steps_, scale);
    for (auto& plane : decoded) plane.resize(width_ * height_);
    return decoded;
  }

  std::vector<std::uint8_t> finish() override { return encoder_.finish(); }

 private:
  std::size_t width_, height_;
  std::vector<float> steps_;
  float lambda_;
  WaveletStreamEncoder encoder_;
  std::vector<WaveletImage> images_;
};

/// Returns step codes by frequency. Frequencies that the runtime's filter averages away get coarser steps. The optimal
/// step is inversely proportional to the square root of the weight.
std::vector<std::uint8_t> dct_step_codes(const TextureChunkFormat& format, const std::vector<float>& weights) {
  const std::size_t size = std::size_t{format.side} * format.side, classes = format.step_code_count() / 2;
  std::vector<double> of_place(size);
  for (std::size_t i = 0; i < weights.size(); ++i) of_place[i % size] += static_cast<double>(weights[i]);
  std::vector<double> logarithms(2 * classes), counts(2 * classes);
  for (std::size_t i = 0; i < format.side && of_place[0] > 0.0; ++i)
    for (const std::size_t direction : {0, 1}) {
      const std::size_t k = direction * classes + static_cast<std::size_t>(std::bit_width(i));
      const double ratio = of_place[direction == 0 ? i : i * format.side] / of_place[0];
      logarithms[k] += std::log(std::max(ratio, kWeightRatioMin));
      counts[k] += 1.0;
    }
  std::vector<std::uint8_t> codes(2 * classes);
  for (std::size_t k = 0; k < codes.size(); ++k)
    codes[k] = counts[k] > 0.0 ? code_of(std::exp(-0.5 * logarithms[k] / counts[k]), 0) : std::uint8_t{0};
  return codes;
}

std::vector<std::uint8_t> wavelet_step_codes(const TextureChunkFormat& format, const std::vector<float>& weights) {
  std::vector<std::uint8_t> codes;
  double first = 0.0;
  for (const WaveletBand& band : wavelet_bands(format.width, format.height)) {
    SelfWeighedMean mean;
    for (std::size_t y = band.y; y < band.y + band.height; ++y)
      for (std::size_t x = band.x; x < band.x + band.width; ++x)
        mean.add(static_cast<double>(weights[y * format.width + x]));
    if (codes.empty()) first = mean.value();
    const double ratio = first > 0.0 ? mean.value() / first : 1.0;
    codes.push_back(code_of(1.0 / std::sqrt(std::clamp(ratio, kWeightRatioMin, 1.0)), 0));
  }
  return codes;
}

/// Returns the weight of a typical coefficient of the lowest frequency.
double typical_weight(const TextureChunkFormat& format, const std::vector<float>& weights) {
  SelfWeighedMean mean;
  if (format.coder == ImageCoder::kDct) {
    for (std::size_t i = 0; i < weights.size(); i += std::size_t{format.side} * format.side)
      mean.add(static_cast<double>(weights[i]));
  } else {
    const WaveletBand band = wavelet_bands(format.width, format.height).front();
    for (std::size_t y = 0; y < band.height; ++y)
      for (std::size_t x = 0; x < band.width; ++x) mean.add(static_cast<double>(weights[y * format.width + x]));
  }
  return mean.value();
}

void write_format(ByteWriter& writer, const TextureChunkFormat& format) {
  writer.byte(static_cast<std::uint8_t>(static_cast<int>(format.coder) | (format.linear ? 2 : 0) |
                                        (format.basis.empty() ? 0 : 4)));
  writer.number(format.width);
  writer.number(format.height);
  writer.byte(static_cast<std::uint8_t>(format.sizes.size()));
  writer.byte(static_cast<std::uint8_t>(format.level_codes.size()));
  for (const std::size_t size : format.sizes) writer.number(size);
  for (std::size_t l = 0; l < format.level_codes.size(); ++l) {
    if (format.basis.empty()) {
      writer.bytes(format.levels[l]);
    } else {
      for (const std::int8_t weight : format.basis[l]) writer.byte(static_cast<std::uint8_t>(weight));
    }
    writer.byte(format.level_codes[l]);
  }
  if (format.coder == ImageCoder::kDct) writer.byte(format.side);
  for (const std::int16_t part : format.rotation) writer.int16(part);
  for (const std::int16_t offset : format.offsets) writer.int16(offset);
  writer.bytes(format.step_codes);
}

/// A sample and the image's share in it.
struct Share {
  std::size_t sample;
  float weight;
};

std::vector<std::vector<Share>> shares_of_images(const ImagePlan& plan) {
  std::vector<std::vector<Share>> shares(plan.image_count());
  for (std::size_t s = 0; s < plan.of_samples.size(); ++s)
    for (const auto& term : plan.of_samples[s]) shares[term.image].push_back({s, term.weight});
  return shares;
}

/// Returns the weight of an image's error in a sample. In a pyramid level, the shares t of a sample's images sum to 1,
/// so the square of their combined error, sum t e, is at most sum t e^2. The images of a basis are orthogonal.
float error_share(const TextureChunkFormat& format, const Share& share) {
  return format.basis.empty() ? share.weight : share.weight * share.weight;
}

/// The remaining difference of each sample, by coefficient. The target of the next image is computed from this
/// difference.
class Residual {
 public:
  /// The `weights`, [sample][coefficient], must outlive this object.
  Residual(std::vector<PlaneCoefficients> lacking, const std::vector<std::vector<float>>& weights)
      : lacking_(std::move(lacking)), weights_(weights) {}

  /// Returns the image that fits its samples best in the least-squares sense. Each coefficient is (sum q w r / t) /
  /// (sum q w), where q comes from error_share(), w is the weight, r is the remaining difference, and t is the image's
  /// share. Sets `weights` to the denominator.
  PlaneCoefficients wanted(const TextureChunkFormat& format, const std::vector<Share>& shares,
                           std::vector<float>& weights) const {
    const std::size_t size = lacking_[0][0].size();
    PlaneCoefficients sums;
    for (auto& plane : sums) plane.assign(size, 0.0f);
    weights.assign(size, 0.0f);
    for (const Share& share : shares) {
      const std::vector<float>& of_sample = weights_[share.sample];
      const float error = error_share(format, share), factor = format.basis.empty() ? error : share.weight;
      for (std::size_t i = 0; i < size; ++i) weights[i] += error * of_sample[i];
      for (std::size_t p = 0; p < 3; ++p)
        for (std::size_t i = 0; i < size; ++i) sums[p][i] += factor * of_sample[i] * lacking_[share.sample][p][i];
    }
    for (auto& plane : sums)
      for (std::size_t i = 0; i < size; ++i) plane[i] = weights[i] > kWeightMin ? plane[i] / weights[i] : 0.0f;
    return sums;
  }

  double error() const {
    double sum = 0.0;
    for (std::size_t s = 0; s < lacking_.size(); ++s)
      for (const auto& plane : lacking_[s])
        for (std::size_t i = 0; i < plane.size(); ++i) sum += static_cast<double>(weights_[s][i] * plane[i] * plane[i]);
    return sum;
  }

  void subtract(const std::vector<Share>& shares, const PlaneCoefficients& image) {
    for (const Share& share : shares)
      for (std::size_t p = 0; p < 3; ++p)
        for (std::size_t i = 0; i < image[p].size(); ++i) lacking_[share.sample][p][i] -= share.weight * image[p][i];
  }

 private:
  static constexpr float kWeightMin = 1e-9f;  // coefficients of lower weight are not visible in any pixel

  std::vector<PlaneCoefficients> lacking_;
  const std::vector<std::vector<float>>& weights_;
};

void choose_steps(TextureChunkFormat& format, const std::vector<float>& weights) {
  format.step_codes =
      format.coder == ImageCoder::kDct ? dct_step_codes(format, weights) : wavelet_step_codes(format, weights);
}

/// Chooses the code of each level's factor from the weights of its images' errors in all samples together.
void choose_scales(TextureChunkFormat& format, const std::vector<float>& weights, double lambda, const ImagePlan& plan,
                   const std::vector<std::vector<Share>>& shares) {
  const double all = typical_weight(format, weights), samples = static_cast<double>(plan.of_samples.size());
  const std::size_t levels = plan.levels.back() + 1;
  std::vector<double> served(levels), images(levels);  // number of samples that use an image
  for (std::size_t i = 0; i < shares.size(); ++i) {
    images[plan.levels[i]] += 1.0;
    for (const Share& share : shares[i]) served[plan.levels[i]] += static_cast<double>(error_share(format, share));
  }
  for (std::size_t l = 0; l < levels; ++l) {
    const double weight = std::max(all / samples * served[l] / images[l], 1e-12);
    const double step = (format.coder == ImageCoder::kDct ? kDctStep : kWaveletStep) * std::sqrt(lambda / weight);
    format.level_codes.push_back(code_of(step, 64));
  }
}

/// Returns the first eigenvectors, each scaled so that its largest weight is 127.
std::vector<std::vector<std::int8_t>> learnt_basis(const std::vector<std::vector<double>>& vectors,
                                                   std::size_t images) {
  std::vector<std::vector<std::int8_t>> basis;
  for (std::size_t k = 0; k < std::min(images, vectors.size()); ++k) {
    double largest = 0.0;
    for (const double part : vectors[k])
      if (std::abs(part) > std::abs(largest)) largest = part;
    basis.emplace_back();
    for (const double part : vectors[k])
      basis.back().push_back(static_cast<std::int8_t>(std::lround(127.0 * part / largest)));
  }
  return basis;
}

std::unique_ptr<ImageCoding> coding_of(const TextureChunkFormat& format, double lambda) {
  if (format.coder == ImageCoder::kDct) return std::make_unique<DctCoding>(format, static_cast<float>(lambda));
  return std::make_unique<WaveletCoding>(format, static_cast<float>(lambda));
}

}  // namespace

ChunkEncoder::ChunkEncoder(const ChunkSource& source, const CoefficientWeights& weights, ImageCoder coder,
                           std::size_t side)
    : source_(source) {
  format_.coder = coder;
  format_.width = source.width;
  format_.height = source.height;
  format_.sizes = source.sizes;
  format_.side = static_cast<std::uint8_t>(side);
  for (std::size_t s = 0; s < source.textures.size(); ++s) {
    weights_.push_back(weights(s));
    summed_weights_.resize(weights_.back().size());
    for (std::size_t i = 0; i < summed_weights_.size(); ++i) summed_weights_[i] += weights_.back()[i];
  }
  choose_steps(format_, summed_weights_);
  const ColourAxes axes = colour_axes(source.textures, source.texel_weights);
  format_.rotation = axes.quaternion;
  PlaneAxes planes{format_.rotation_rows(), {}};
  for (std::size_t p = 0; p < 3; ++p) {
    float offset = 0.0f;
    for (std::size_t c = 0; c < 3; ++c) offset += planes.rows[p][c] * axes.mean[c];
    format_.offsets[p] = static_cast<std::int16_t>(std::clamp(std::lround(offset / kOffsetUnit), -32767l, 32767l));
    planes.offsets[p] = kOffsetUnit * static_cast<float>(format_.offsets[p]);
  }
  HostImageTransforms on_host;
  ImageTransforms& transforms = source.transforms != nullptr ? *source.transforms : on_host;
  coefficients_ = transforms.coefficients({coder, source.width, source.height, side}, source.textures, planes);
}

/// Computes the eigenvectors of the matrix of products of any two samples. Coefficients are multiplied by the square
/// roots of their errors' weights.
const std::vector<std::vector<double>>& ChunkEncoder::eigenvectors() {
  if (eigenvectors_) return *eigenvectors_;
  const std::size_t n = coefficients_.size();
  std::vector<double> products(n * n);
  std::vector<float> rooted;
  for (std::size_t s = 0; s < n; ++s)
    for (std::size_t p = 0; p < 3; ++p) {
      rooted = coefficients_[s][p];
      for (std::size_t i = 0; i < rooted.size(); ++i) rooted[i] *= std::sqrt(weights_[s][i]);
      for (std::size_t t = 0; t <= s; ++t) {
        double sum = 0.0;
        for (std::size_t i = 0; i < rooted.size(); ++i)
          sum += static_cast<double>(rooted[i] * std::sqrt(weights_[t][i]) * coefficients_[t][p][i]);
        products[s * n + t] += sum;
        if (t != s) products[t * n + s] += sum;
      }
    }
  return eigenvectors_.emplace(symmetric_eigenvectors(std::move(products), n));
}

EncodedChunk ChunkEncoder::encode(const ChunkSettings& settings, const std::function<void()>& step) {
  MULTUM_CHECK(settings.lambda > 0.0 && settings.coder == format_.coder);
  TextureChunkFormat format = format_;
  format.levels = settings.levels;
  format.linear = settings.linear;
  if (format.levels.empty()) format.basis = learnt_basis(eigenvectors(), settings.basis_images);
  const auto plan = format.plan();
  MULTUM_CHECK(plan.has_value() && plan->of_samples.size() == source_.textures.size());
  const auto shares = shares_of_images(*plan);
  choose_scales(format, summed_weights_, settings.lambda, *plan, shares);
  const auto coding = coding_of(format, settings.lambda);
  Residual left(coefficients_, weights_);
  std::optional<Residual> aim;  // for an open loop: the sum that the images should have
  if (settings.open_loop) aim.emplace(left);
  for (std::size_t i = 0; i < plan->image_count(); ++i) {
    step();
    std::vector<float> of_image;
    auto wanted = (aim ? *aim : left).wanted(format, shares[i], of_image);
    if (aim) aim->subtract(shares[i], wanted);
    const std::size_t level = plan->levels[i];
    left.subtract(shares[i], coding->add(std::move(wanted), std::move(of_image), plan->parents[i], level,
                                         format.level_scale(level)));
  }
  ByteWriter writer;
  write_format(writer, format);
  writer.bytes(coding->finish());
  return {writer.written(), left.error()};
}

}  // namespace multum
