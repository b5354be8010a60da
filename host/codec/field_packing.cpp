// SPDX-License-Identifier: Apache-2.0
#include "host/codec/field_packing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>

#include "host/asset/inferred/field_files.h"
#include "host/asset/inferred/filter_matrix.h"
#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/output_file.h"
#include "host/base/files/output_paths.h"
#include "host/base/processes/parallel.h"
#include "host/codec/chunk_choice.h"
#include "host/codec/drawn_weights.h"
#include "host/codec/field_description.h"
#include "host/codec/packed_file.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr int kRoundsMax = 12;
constexpr double kNearEnough = 0.985;  // of the target
constexpr double kDefaultRatio = 384.0;
constexpr double kLambdaMin = 1e-4, kLambdaMax = 1e9, kLambdaFirst = 500.0;
constexpr int kAlphaPassesMax = 12;  // mostly one or two: each makes the mean smaller, by less and less

/// Progress from several threads.
class SharedProgress {
 public:
  explicit SharedProgress(Progress* progress) : progress_(progress) {}
  void advance(std::uint64_t units) {
    const std::lock_guard lock(mutex_);
    progress_advance(progress_, units);
  }

 private:
  Progress* progress_;
  std::mutex mutex_;
};

std::string parent_folder(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

/// What weighs the errors of an object's textures.
struct ObjectWeights {
  std::vector<FilterMatrix> poses;
  std::vector<std::size_t> pose_of_sample;
  std::vector<std::vector<std::vector<float>>> shares;  // [sample][layer][cell]
  double pixels = 0.0;                                  // covered, of all samples

  /// [pose][coefficient], made when first asked for.
  const std::vector<std::vector<float>>& energies(std::size_t mapping_pose, ImageCoder coder, std::size_t side) {
    const FilterMatrix& one = poses[mapping_pose];
    const CoefficientLayout layout{coder, static_cast<std::size_t>(one.texture_width),
                                   static_cast<std::size_t>(one.texture_height), side};
    const std::lock_guard lock(mutex);
    auto& made = energies_of[{static_cast<int>(coder), side, layout.width, layout.height}];
    if (!made.empty()) return made;
    made.resize(poses.size());
    for (std::size_t p = 0; p < poses.size(); ++p)
      if (poses[p].texture_width == one.texture_width && poses[p].texture_height == one.texture_height)
        made[p] = coefficient_energies(poses[p], layout);
    return made;
  }

  std::mutex mutex;
  std::map<std::tuple<int, std::size_t, std::size_t, std::size_t>, std::vector<std::vector<float>>> energies_of;
};

struct ChunkToCode {
  std::size_t layer = 0, block = 0;  // of the description
  std::size_t object = 0, layer_of_object = 0;
  ObjectWeights* weights = nullptr;
  std::size_t pose = 0;  // the first of those that draw it: all have its mapping
  ChunkSource source;
  std::vector<std::vector<std::size_t>> seen_at;  // [chunk sample], samples that draw it
};

struct FieldSource {
  FieldDescription description;
  std::vector<std::unique_ptr<ObjectWeights>> weights;  // of objects
  std::vector<ChunkToCode> chunks;
  double values = 0.0;  // of all frames, three a pixel
};

void read_matrices(const std::string& folder, const InferredManifest& field, const InferredObject& object,
                   ObjectWeights& weights) {
  const ObjectPoses poses = object_poses(field, object);
  weights.pose_of_sample = poses.of_sample;
  for (const std::size_t s : poses.first_samples) {
    const std::string path = folder + "/" + matrix_name(field.samples[s], object);
    FilterMatrix matrix = read_filter_matrix(path);
    const TextureMapping& mapping = object.mappings[static_cast<std::size_t>(object.mapping_of_sample[s])];
    if (matrix.texture_width != mapping.width || matrix.texture_height != mapping.height)
      refuse_file(path, fmt::format("is of a texture of {} x {}, the manifest's mapping of {} x {}",
                                    matrix.texture_width, matrix.texture_height, mapping.width, mapping.height));
    weights.poses.push_back(std::move(matrix));
  }
}

using TexturesByName = std::map<std::string, InferredTexture>;

TexturesByName read_textures(const std::string& folder, const InferredObject& object, int threads) {
  TexturesByName textures;
  for (const InferredLayer& layer : object.layers)
    for (std::size_t s = 0; s < layer.textures.size(); ++s)
      if (!layer.textures[s].empty()) textures[layer.textures[s]];
  std::vector<std::pair<const std::string, InferredTexture>*> list;
  for (auto& entry : textures) list.push_back(&entry);
  for_each_item(static_cast<int>(list.size()), threads, [&](int i) {
    auto& [name, texture] = *list[static_cast<std::size_t>(i)];
    texture = read_inferred_texture(folder + "/" + name);
  });
  for (const InferredLayer& layer : object.layers)
    for (std::size_t s = 0; s < layer.textures.size(); ++s) {
      if (layer.textures[s].empty()) continue;
      const TextureMapping& mapping = object.mappings[static_cast<std::size_t>(object.mapping_of_sample[s])];
      const InferredTexture& texture = textures[layer.textures[s]];
      if (texture.width != mapping.width || texture.height != mapping.height)
        refuse_file(folder + "/" + layer.textures[s],
                    fmt::format("is of {} x {} texels, the manifest's mapping of {} x {}", texture.width,
                                texture.height, mapping.width, mapping.height));
    }
  return textures;
}

void find_shares(const InferredObject& object, const TexturesByName& textures, int threads, ObjectWeights& weights) {
  weights.shares.resize(object.mapping_of_sample.size());
  for_each_item(static_cast<int>(weights.shares.size()), threads, [&](int i) {
    const auto s = static_cast<std::size_t>(i);
    const FilterMatrix& matrix = weights.poses[weights.pose_of_sample[s]];
    const std::vector<float> black(3 * static_cast<std::size_t>(matrix.layout().texel_count));
    std::vector<const std::vector<float>*> layers;
    for (const InferredLayer& layer : object.layers)
      layers.push_back(layer.textures[s].empty() ? &black : &textures.at(layer.textures[s]).texels);
    weights.shares[s] = layer_shares(matrix, layers);
  });
}

std::vector<float> finest_gamma_coded(const InferredTexture& texture) {
  std::vector<float> values(3u * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height));
  std::transform(texture.texels.begin(), texture.texels.begin() + std::ssize(values), values.begin(),
                 [](float radiance) { return gamma_coded(std::min(1.0f, radiance)); });
  return values;
}

// Nothing when no sample of the block has a texture.
std::optional<ChunkToCode> chunk_of(const InferredManifest& field, const SampleGrid& grid, const InferredObject& object,
                                    const InferredLayer& layer, const FieldBlock& block,
                                    const TexturesByName& textures) {
  ChunkToCode chunk;
  auto& textures_of = chunk.source.textures;
  chunk.source.sizes = block.chunk_sizes();
  std::size_t count = 1;
  for (const std::size_t size : chunk.source.sizes) count *= size;
  textures_of.resize(count);
  chunk.seen_at.resize(count);
  for (const std::size_t s : grid.samples_in(block)) {
    const TextureMapping& mapping = object.mappings[static_cast<std::size_t>(object.mapping_of_sample[s])];
    chunk.source.width = static_cast<std::size_t>(mapping.width);
    chunk.source.height = static_cast<std::size_t>(mapping.height);
    if (layer.textures[s].empty()) continue;
    const std::size_t number = block.chunk_sample(field.samples[s].at);
    if (textures_of[number].empty()) textures_of[number] = finest_gamma_coded(textures.at(layer.textures[s]));
    chunk.seen_at[number].push_back(s);
  }
  // What nobody draws is what costs nothing: a neighbour's.
  const auto first = std::find_if(textures_of.begin(), textures_of.end(), [](const auto& t) { return !t.empty(); });
  if (first == textures_of.end()) return {};
  const std::vector<float>* last = &*first;
  for (std::vector<float>& texture : textures_of) {
    if (texture.empty()) texture = *last;
    last = &texture;
  }
  return chunk;
}

void find_masses_and_pose(ChunkToCode& chunk) {
  const ObjectWeights& weights = *chunk.weights;
  std::set<std::size_t> poses;
  for (const auto& samples : chunk.seen_at)
    for (const std::size_t s : samples) poses.insert(weights.pose_of_sample[s]);
  chunk.pose = *poses.begin();
  std::vector<float>& masses = chunk.source.texel_weights;
  masses.resize(chunk.source.width * chunk.source.height);
  for (const std::size_t pose : poses) {
    const std::vector<float> one = texel_masses(weights.poses[pose]);
    for (std::size_t i = 0; i < masses.size(); ++i) masses[i] += one[i];
  }
}

void read_object(const FieldPackSettings& settings, const InferredManifest& field, std::size_t number,
                 const SampleGrid& grid, FieldSource& source) {
  const InferredObject& object = field.objects[number];
  source.weights.push_back(std::make_unique<ObjectWeights>());
  if (object.layers.empty()) return;
  ObjectWeights& weights = *source.weights.back();
  read_matrices(settings.folder, field, object, weights);
  for (const std::size_t pose : weights.pose_of_sample)
    for (const float coverage : weights.poses[pose].coverage) weights.pixels += static_cast<double>(coverage);
  const TexturesByName textures = read_textures(settings.folder, object, settings.threads);
  find_shares(object, textures, settings.threads, weights);
  std::size_t texels = 1;
  for (const TextureMapping& mapping : object.mappings)
    texels = std::max(texels, static_cast<std::size_t>(mapping.width) * static_cast<std::size_t>(mapping.height));
  const std::size_t samples_max = std::max<std::size_t>(1, TextureChunkFormat::kTexelsMax / 2 / texels);
  for (std::size_t l = 0; l < object.layers.size(); ++l) {
    const InferredLayer& layer = object.layers[l];
    PackedLayer packed{number,
                       layer.name,
                       field_blocks(field, grid, object.mapping_of_sample, layer.textures, settings.block, samples_max),
                       {}};
    for (std::size_t s = 0; s < layer.textures.size(); ++s)
      if (layer.textures[s].empty()) packed.unseen.push_back(static_cast<int>(s));
    for (std::size_t b = 0; b < packed.blocks.size(); ++b) {
      if (packed.blocks[b].varying.size() > ParameterPyramid::kDimensionsMax)
        throw Error(ErrorCode::kInput, fmt::format("layer '{}' of object '{}' varies with {} parameters, expected at "
                                                   "most {}",
                                                   layer.name, object.name, packed.blocks[b].varying.size(),
                                                   ParameterPyramid::kDimensionsMax));
      auto chunk = chunk_of(field, grid, object, layer, packed.blocks[b], textures);
      if (!chunk) continue;
      chunk->layer = source.description.layers.size();
      chunk->block = b;
      chunk->object = number;
      chunk->layer_of_object = l;
      chunk->weights = &weights;
      find_masses_and_pose(*chunk);
      source.chunks.push_back(std::move(*chunk));
    }
    source.description.layers.push_back(std::move(packed));
  }
}

FieldSource read_field(const FieldPackSettings& settings, Progress* progress) {
  const std::string manifest_path = settings.folder + "/" + kInferredManifestName;
  InferredManifest field = read_inferred_manifest(manifest_path);
  FieldSource source;
  source.values = 3.0 * field.width * field.height * static_cast<double>(field.samples.size());
  SampleGrid& grid = source.description.grid;
  try {
    grid = sample_grid(field.samples);
  } catch (const Error& error) {
    refuse_file(manifest_path, error.what());
  }
  for (std::size_t k = 0; k < field.objects.size(); ++k) {
    read_object(settings, field, k, grid, source);
    progress_advance(progress, 0);
  }
  for (InferredObject& object : field.objects) object.layers.clear();
  // Against the packed file's folder.
  if (fs::path(field.geometry_file).is_relative()) {
    const fs::path geometry = fs::absolute(settings.folder + "/" + field.geometry_file).lexically_normal();
    const fs::path folder = fs::absolute(parent_folder(settings.output)).lexically_normal();
    field.geometry_file = (settings.has_absolute_geometry ? geometry : geometry.lexically_relative(folder)).string();
  }
  source.description.field = std::move(field);
  return source;
}

/// Of a round before, kept while lambda stays near.
struct KeptChunk {
  ChosenChunk chosen;
  double lambda = 0.0;     // it was coded with
  double chosen_at = 0.0;  // lambda at which all candidates were tried; 0: never
};

ChosenChunk coded(const ChunkToCode& chunk, const ChunkCandidates& candidates, const ChunkSettings* settings,
                  double lambda, SharedProgress& progress) {
  ObjectWeights& weights = *chunk.weights;
  const auto weights_of = [&](ImageCoder coder, std::size_t side) -> CoefficientWeights {
    const auto& energies = weights.energies(chunk.pose, coder, side);
    return
        [&, cells = cells_of_coefficients({coder, chunk.source.width, chunk.source.height, side})](std::size_t sample) {
          progress.advance(0);
          std::vector<float> sum(cells.size());
          for (const std::size_t s : chunk.seen_at[sample]) {
            const std::vector<float>& shares = weights.shares[s][chunk.layer_of_object];
            const std::vector<float>& energy = energies[weights.pose_of_sample[s]];
            for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += energy[j] * shares[cells[j]];
          }
          return sum;
        };
  };
  const auto step = [&progress] { progress.advance(0); };
  if (settings == nullptr) return best_chunk(chunk.source, weights_of, candidates, lambda, step);
  ChosenChunk result{{}, *settings};
  result.settings.lambda = lambda;
  ChunkEncoder encoder(chunk.source, weights_of(settings->coder, settings->side), settings->coder, settings->side);
  result.chunk = encoder.encode(result.settings, step);
  return result;
}

/// Everything coded for one lambda.
struct Round {
  double lambda = 0.0, mse = 0.0;
  std::vector<double> object_mse;  // of each object's pixels
  double mse_covered = 0.0;
  std::vector<EncodedChunk> chunks;
  std::vector<std::uint8_t> file;
};

/// Codes all chunks again and again, for one lambda after another.
class FieldCoder {
 public:
  FieldCoder(const FieldSource& source, const std::vector<std::uint8_t>& description, const FieldPackSettings& settings,
             Progress* progress)
      : source_(source),
        description_(description),
        settings_(settings),
        progress_(progress),
        kept_(source.chunks.size()),
        shares_(source.weights.size(), 1.0) {
    for (const ChunkToCode& chunk : source.chunks)
      candidates_.push_back(chunk_candidates(chunk.source.sizes, settings.pyramid, settings.coder, settings.open_loop));
  }

  Round code(double lambda) {
    ++rounds_;
    progress_stage(progress_, fmt::format("code, a bit worth {:.4g}", lambda));
    std::vector<std::size_t> all(source_.chunks.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    code_chunks(all, lambda);
    Round round;
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

  double lambda_of(std::size_t object, double lambda) const { return std::max(kLambdaMin, lambda * shares_[object]); }
  int rounds() const { return rounds_; }

  /// Lowers the share of lambda of each object whose error is above alpha times the mean. False: there is none.
  bool hold(const Round& round) {
    const double mse_max = settings_.alpha * round.mse_covered;
    bool any = false;
    for (std::size_t k = 0; k < round.object_mse.size(); ++k) {
      if (settings_.alpha <= 0.0 || round.object_mse[k] <= mse_max) continue;
      any = true;
      hold_object(k, round.lambda, round.object_mse[k], mse_max);
    }
    return any;
  }

 private:
  /// A choice of coder and pyramid is kept while lambda is within this factor of that for which it was made. On
  /// field_demo1 a search that starts at 500 ends within it.
  static constexpr double kChoiceRange = 2.0;

  void code_chunks(const std::vector<std::size_t>& numbers, double lambda) {
    SharedProgress shared(progress_);
    for_each_item(static_cast<int>(numbers.size()), settings_.threads, [&](int i) {
      const std::size_t c = numbers[static_cast<std::size_t>(i)];
      const ChunkToCode& chunk = source_.chunks[c];
      const double own = lambda_of(chunk.object, lambda);
      KeptChunk& kept = kept_[c];
      if (kept.lambda != own) {
        const bool is_near =
            kept.chosen_at > 0.0 && own <= kChoiceRange * kept.chosen_at && kept.chosen_at <= kChoiceRange * own;
        const ChunkSettings before = kept.chosen.settings;
        kept.chosen = coded(chunk, candidates_[c], is_near ? &before : nullptr, own, shared);
        kept.lambda = own;
        if (!is_near) kept.chosen_at = own;
      }
      shared.advance(1);
    });
  }

  double object_mse(std::size_t object) const {
    double error = 0.0;
    for (std::size_t c = 0; c < kept_.size(); ++c)
      if (source_.chunks[c].object == object) error += kept_[c].chosen.chunk.error;
    const double values = 3.0 * source_.weights[object]->pixels;
    return values > 0.0 ? error / values : 0.0;
  }

  /// Errors grow as lambda^0.6: a few steps of that lead to a share of lambda at which the object's error is met. A
  /// share, not a lambda: when the others' lambda changes for the file's size, so do its error and the mean.
  void hold_object(std::size_t object, double lambda, double mse, double mse_max) {
    std::vector<std::size_t> numbers;
    for (std::size_t c = 0; c < kept_.size(); ++c)
      if (source_.chunks[c].object == object) numbers.push_back(c);
    for (int i = 0; i < 6 && mse > mse_max && lambda_of(object, lambda) > kLambdaMin; ++i) {
      shares_[object] *= std::pow(0.985 * mse_max / mse, 1.0 / 0.6);
      code_chunks(numbers, lambda);
      mse = object_mse(object);
    }
  }

  const FieldSource& source_;
  const std::vector<std::uint8_t>& description_;
  const FieldPackSettings& settings_;
  Progress* progress_;
  std::vector<ChunkCandidates> candidates_;  // of each chunk
  std::vector<KeptChunk> kept_;              // the same
  std::vector<double> shares_;               // of lambda, of each object, up to 1
  int rounds_ = 0;
};

/// The largest file of at most so many bytes, or the smallest of at most so much error: log(bytes) and log(error) are
/// nearly linear in log(lambda), of slopes -0.56 and 0.6 on a field of 64 samples.
template <typename Code>
Round search(double limit, bool is_error, double lambda, const Code& code) {
  const auto excess_of = [&](const Round& round) {
    const double value = is_error ? round.mse : static_cast<double>(round.file.size());
    return std::log(std::max(value, 1e-12) / limit);
  };
  const double slope = is_error ? 0.6 : -0.56, aim = 0.5 * std::log(kNearEnough);
  std::optional<Round> best;
  struct Side {
    double x = 0.0, excess = 0.0;
    bool is_there = false;
  } met, missed;  // the nearest of either kind
  double x = std::log(lambda);
  double least = 0.0;
  for (int i = 0; i < kRoundsMax; ++i) {
    Round round = code(std::exp(x));
    const double excess = excess_of(round);
    least = i == 0 ? excess : std::min(least, excess);
    (excess <= 0.0 ? met : missed) = {x, excess, true};
    if (excess <= 0.0 && (!best || excess > excess_of(*best))) best = std::move(round);
    if (excess <= 0.0 && excess >= 2.0 * aim) break;
    const double edge = std::log(((excess > 0.0) == is_error) ? kLambdaMin : kLambdaMax);
    if (!(met.is_there && missed.is_there) && x == edge) break;
    double next = x + (aim - excess) / slope;
    if (met.is_there && missed.is_there) {
      const double share = std::clamp((aim - met.excess) / (missed.excess - met.excess), 0.1, 0.9);
      next = met.x + share * (missed.x - met.x);
      if (std::abs(met.x - missed.x) < 1e-3) break;
    }
    x = std::clamp(next, std::log(kLambdaMin), std::log(kLambdaMax));
  }
  if (best) return std::move(*best);
  throw Error(ErrorCode::kUsage, is_error
                                     ? fmt::format("an error of {:g} cannot be met: {:.4g} is the least that was found",
                                                   limit, limit * std::exp(least))
                                     : fmt::format("{:.0f} bytes cannot be met: {:.0f} is the least that was found",
                                                   limit, limit * std::exp(least)));
}

void write_packed(const std::vector<std::uint8_t>& bytes, const std::string& path) {
  AtomicFile file(path);
  OutputFile out(file.temporary_path(), path);
  out.write(bytes.data(), bytes.size());
  out.close();
  file.commit();
}

}  // namespace

FieldPackReport pack_field(const FieldPackSettings& settings, Progress* progress) {
  MULTUM_CHECK(settings.block >= 1 && (settings.alpha == 0.0 || settings.alpha > 1.0));
  if (!settings.output.ends_with(".mpt"))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: is not a name for a packed field, expected one that ends in .mpt", settings.output));
  check_paths_differ({settings.folder + "/" + kInferredManifestName}, {settings.output});
  check_writable(settings.output);
  progress_start(progress, 0);
  progress_stage(progress, "read");
  FieldSource source = read_field(settings, progress);
  for (ChunkToCode& chunk : source.chunks) chunk.source.transforms = settings.transforms;
  const std::vector<std::uint8_t> description = encode_description(source.description);
  FieldPackReport report;
  progress_start(progress, source.chunks.size() * (settings.target.lambda ? 1u : 4u));
  FieldCoder coder(source, description, settings, progress);
  const auto code = [&](double lambda) { return coder.code(lambda); };
  const FieldTarget& target = settings.target;
  const double by_ratio = source.values / target.ratio.value_or(kDefaultRatio);
  const auto met = [&](double first) {
    return target.lambda ? code(*target.lambda)
           : target.mse  ? search(*target.mse, true, first, code)
                         : search(target.bytes.value_or(by_ratio), false, first, code);
  };
  Round round = met(kLambdaFirst);
  // What the objects that are held take, the others are short of: then one more may be above alpha times the mean.
  for (int pass = 0; pass < kAlphaPassesMax && coder.hold(round); ++pass) round = met(round.lambda);
  write_packed(round.file, settings.output);
  progress_finish(progress);
  report.bytes = round.file.size();
  report.description_bytes = description.size();
  report.raw_bytes = static_cast<std::uint64_t>(source.values);
  report.lambda = round.lambda;
  report.mse = round.mse;
  report.rounds = coder.rounds();
  report.mse_covered = round.mse_covered;
  for (std::size_t k = 0; k < source.weights.size(); ++k) {
    if (!(source.weights[k]->pixels > 0.0)) continue;
    report.objects.push_back({source.description.field.objects[k].name, source.weights[k]->pixels, round.object_mse[k],
                              coder.lambda_of(k, round.lambda)});
    if (settings.alpha > 0.0 && round.object_mse[k] > settings.alpha * round.mse_covered) report.is_alpha_met = false;
  }
  for (std::size_t c = 0; c < source.chunks.size(); ++c) {
    const PackedLayer& layer = source.description.layers[source.chunks[c].layer];
    report.chunks.push_back({source.description.field.objects[layer.object].name, layer.name, source.chunks[c].block,
                             round.chunks[c].bytes.size(), round.chunks[c].error / source.values});
  }
  return report;
}

}  // namespace multum
