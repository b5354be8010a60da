// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packing/field_coder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/fields/codec/drawn_weights.h"
#include "host/fields/codec/packed_file.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

/// A choice of coder and pyramid is kept while lambda is within this factor of the lambda at which it was chosen. On
/// field_demo1, a search that starts at lambda = 500 ends within this factor.
constexpr double kChoiceRange = 2.0;

}  // namespace

std::uint64_t FieldCoder::bytes_of(const ChunkToCode& chunk, bool open_loop) {
  // Each texel of a sample needs three coefficients, their weight, and the differences that are not coded yet (twice
  // for an open loop). The images with three coded coefficients per texel take four thirds of an image together.
  const std::uint64_t texel_bytes = 12 + 4 + (open_loop ? 24 : 12) + 16;
  return texel_bytes * chunk.width * chunk.height * chunk.textures.size();
}

FieldCoder::FieldCoder(const FieldSource& source, const std::vector<std::uint8_t>& description,
                       const FieldCoderSettings& settings, Progress* progress)
    : source_(source),
      description_(description),
      settings_(settings),
      progress_(progress),
      textures_(source.chunks.size()),
      kept_(source.chunks.size()),
      shares_(source.weights.size(), 1.0) {
  std::uint64_t textures = 0, most = 0;
  for (const ChunkToCode& chunk : source.chunks) {
    candidates_.push_back(chunk_candidates(chunk.sizes, settings.pyramid, settings.coder, settings.open_loop));
    textures += chunk.texture_bytes();
    most = std::max(most, chunk.texture_bytes() + bytes_of(chunk, settings.open_loop));
  }
  if (most > settings.memory_bytes)
    throw Error(ErrorCode::kUsage, fmt::format("coding the largest chunk needs {} MiB, but only {} MiB are available; "
                                               "allow more memory, or make blocks smaller",
                                               (most >> 20) + 1, settings.memory_bytes >> 20));
  keeps_textures_ = textures + most <= settings.memory_bytes;
  if (keeps_textures_) gate_.emplace(settings.memory_bytes - textures);
  else gate_.emplace(settings.memory_bytes);
}

void FieldCoder::advance(std::uint64_t units) {
  const std::lock_guard lock(progress_mutex_);
  progress_advance(progress_, units);
}

double FieldCoder::lambda_of(std::size_t object, double lambda) const {
  return std::max(kLambdaMin, lambda * shares_[object]);
}

FieldRound FieldCoder::code(double lambda) {
  ++rounds_;
  progress_stage(progress_, fmt::format("code with lambda {:.4g}", lambda));
  std::vector<std::size_t> all(source_.chunks.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  code_chunks(all, lambda);
  FieldRound round;
  round.lambda = lambda;
  std::vector<SectionSource> sections = {{static_cast<std::uint32_t>(SectionKind::kDescription), 0, 0, description_}};
  for (std::size_t c = 0; c < kept_.size(); ++c) {
    const EncodedChunk& chunk = kept_[c].chosen.chunk;
    round.chunks.push_back(chunk);
    round.mse += chunk.error / source_.values;
    sections.push_back({static_cast<std::uint32_t>(SectionKind::kChunk),
                        static_cast<std::uint32_t>(source_.chunks[c].layer),
                        static_cast<std::uint32_t>(source_.chunks[c].block), chunk.bytes});
  }
  double covered = 0.0;
  for (std::size_t k = 0; k < source_.weights.size(); ++k) {
    round.object_mse.push_back(object_mse(k));
    covered += 3.0 * source_.weights[k]->pixels;
  }
  round.mse_covered = covered > 0.0 ? round.mse * source_.values / covered : 0.0;
  round.file = packed_file(sections);
  return round;
}

void FieldCoder::code_chunks(const std::vector<std::size_t>& numbers, double lambda) {
  for_each_item(static_cast<int>(numbers.size()), settings_.threads, [&](int i) {
    const std::size_t c = numbers[static_cast<std::size_t>(i)];
    const double own = lambda_of(source_.chunks[c].object, lambda);
    KeptChunk& kept = kept_[c];
    if (kept.lambda != own) {
      const bool is_near =
          kept.chosen_at > 0.0 && own <= kChoiceRange * kept.chosen_at && kept.chosen_at <= kChoiceRange * own;
      const ChunkSettings before = kept.chosen.settings;
      kept.chosen = coded(c, is_near ? &before : nullptr, own);
      kept.lambda = own;
      if (!is_near) kept.chosen_at = own;
    }
    advance(1);
  });
}

const ChunkSource& FieldCoder::textures_of(std::size_t number, std::optional<ChunkSource>& own) {
  std::optional<ChunkSource>& textures = keeps_textures_ ? textures_[number] : own;
  if (!textures) {
    textures = read_chunk_source(source_, source_.chunks[number]);
    textures->transforms = settings_.transforms;
  }
  return *textures;
}

ChosenChunk FieldCoder::coded(std::size_t number, const ChunkSettings* before, double lambda) {
  if (settings_.journal != nullptr)
    if (auto found = settings_.journal->find(number, lambda)) {
      ++chunks_resumed_;
      return std::move(*found);
    }
  const ChunkToCode& chunk = source_.chunks[number];
  const MemoryGate::Pass pass(
      *gate_, bytes_of(chunk, settings_.open_loop) + (keeps_textures_ ? std::uint64_t{0} : chunk.texture_bytes()));
  std::optional<ChunkSource> own;
  const ChunkSource& textures = textures_of(number, own);
  const auto weights_of = [&](ImageCoder coder, std::size_t side) -> CoefficientWeights {
    const PoseEnergies& energies = chunk.weights->energies.at({coder, side});
    return [&, cells = cells_of_coefficients({coder, chunk.width, chunk.height, side})](std::size_t sample) {
      advance(0);
      std::vector<float> sum(cells.size());
      for (const std::size_t s : chunk.seen_at[sample]) {
        const std::vector<float>& shares = chunk.weights->shares[s][chunk.layer_of_object];
        const std::vector<float> energy = energies.of(chunk.weights->pose_of_sample[s], cells);
        for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += energy[j] * shares[cells[j]];
      }
      return sum;
    };
  };
  const auto step = [this] { advance(0); };
  ChosenChunk result;
  if (before == nullptr) {
    result = best_chunk(textures, weights_of, candidates_[number], lambda, step);
  } else {
    result.settings = *before;
    result.settings.lambda = lambda;
    ChunkEncoder encoder(textures, weights_of(before->coder, before->side), before->coder, before->side);
    result.chunk = encoder.encode(result.settings, step);
  }
  if (settings_.journal != nullptr) settings_.journal->add(number, lambda, result);
  return result;
}

bool FieldCoder::hold(const FieldRound& round) {
  const double mse_max = settings_.alpha * round.mse_covered;
  bool any = false;
  for (std::size_t k = 0; k < round.object_mse.size(); ++k) {
    if (settings_.alpha <= 0.0 || round.object_mse[k] <= mse_max) continue;
    any = true;
    hold_object(k, round.lambda, round.object_mse[k], mse_max);
  }
  return any;
}

double FieldCoder::object_mse(std::size_t object) const {
  double error = 0.0;
  for (std::size_t c = 0; c < kept_.size(); ++c)
    if (source_.chunks[c].object == object) error += kept_[c].chosen.chunk.error;
  const double values = 3.0 * source_.weights[object]->pixels;
  return values > 0.0 ? error / values : 0.0;
}

/// Errors grow as lambda^0.6, so a few steps find a share of lambda at which the object's error is within its limit.
/// The result is a share of lambda instead of a lambda, because the search for the file size changes lambda. The
/// object's error and the mean error then change together.
void FieldCoder::hold_object(std::size_t object, double lambda, double mse, double mse_max) {
  std::vector<std::size_t> numbers;
  for (std::size_t c = 0; c < kept_.size(); ++c)
    if (source_.chunks[c].object == object) numbers.push_back(c);
  for (int i = 0; i < 6 && mse > mse_max && lambda_of(object, lambda) > kLambdaMin; ++i) {
    shares_[object] *= std::pow(0.985 * mse_max / mse, 1.0 / 0.6);
    code_chunks(numbers, lambda);
    mse = object_mse(object);
  }
}

}  // namespace multum
