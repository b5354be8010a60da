// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/field_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>

#include "host/fields/codec/drawn_weights.h"
#include "host/fields/inferred/field_files.h"
#include "host/fields/inferred/filter_matrix.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/checksum.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

template <typename T>
void update(Checksum& checksum, const std::vector<T>& values) {
  checksum.update(values.data(), values.size() * sizeof(T));
}

InferredTexture read_texture_of(const std::string& folder, const std::string& name, std::size_t width,
                                std::size_t height) {
  const std::string path = folder + "/" + name;
  InferredTexture texture = read_inferred_texture(path);
  if (static_cast<std::size_t>(texture.width) != width || static_cast<std::size_t>(texture.height) != height)
    refuse_file(path, fmt::format("has {} x {} texels, but the manifest's mapping has {} x {}", texture.width,
                                  texture.height, width, height));
  return texture;
}

const TextureMapping& mapping_of_sample(const InferredObject& object, std::size_t sample) {
  return object.mappings[static_cast<std::size_t>(object.mapping_of_sample[sample])];
}

/// Reads an object and measures the weights of its errors. Each thread holds the matrices of only a few poses at a
/// time.
class ObjectReading {
 public:
  ObjectReading(const FieldSourceSettings& settings, const InferredManifest& field, const InferredObject& object,
                ObjectWeights& weights)
      : settings_(settings), field_(field), object_(object), weights_(weights) {
    const ObjectPoses poses = object_poses(field, object);
    weights.pose_of_sample = poses.of_sample;
    for (const std::size_t s : poses.first_samples) poses_.push_back({s, {}, {}, 0.0, {}});
    for (std::size_t s = 0; s < poses.of_sample.size(); ++s) poses_[poses.of_sample[s]].samples.push_back(s);
  }

  void find_shares(Progress* progress) {
    weights_.shares.resize(object_.mapping_of_sample.size());
    for_each_item(static_cast<int>(poses_.size()), settings_.threads, [&](int p) {
      Pose& pose = poses_[static_cast<std::size_t>(p)];
      const FilterMatrix matrix = read_matrix(pose);
      Checksum checksum;
      update(checksum, matrix.row_begin);
      update(checksum, matrix.columns);
      update(checksum, matrix.weights);
      update(checksum, matrix.coverage);
      pose.checksum = checksum.text();
      for (const float coverage : matrix.coverage) pose.pixels += static_cast<double>(coverage);
      pose.masses = texel_masses(matrix);
      for (const std::size_t s : pose.samples) weights_.shares[s] = shares_of(s, matrix);
      advance(progress);
    });
    for (const std::size_t p : weights_.pose_of_sample) weights_.pixels += poses_[p].pixels;
  }

  /// Measures several poses of one coder at a time, because poses can share basis images.
  void find_energies(Progress* progress) {
    struct Item {
      CoderAndSide coder;
      std::vector<std::size_t> poses;  // poses whose textures have the same size
    };
    constexpr std::size_t kPosesMax = 8;
    const auto measured = measured_of_poses();
    const auto is_measured = [&](std::size_t p) { return measured[p].front() == p; };
    std::map<std::pair<int, int>, std::vector<std::size_t>> by_size;
    for (std::size_t p = 0; p < poses_.size(); ++p)
      if (is_measured(p)) by_size[{mapping_of(p).width, mapping_of(p).height}].push_back(p);
    std::vector<Item> items;
    for (const CoderAndSide& coder : settings_.coders) {
      weights_.energies.emplace(coder, PoseEnergies(poses_.size()));
      for (const auto& [size, poses] : by_size)
        for (std::size_t k = 0; k < poses.size(); ++k) {
          if (k % kPosesMax == 0) items.push_back({coder, {}});
          items.back().poses.push_back(poses[k]);
        }
      for (std::size_t p = 0; p < poses_.size(); ++p)
        if (!is_measured(p))
          weights_.energies.at(coder).set_like(p, layout_of(coder, p), measured[p], poses_[p].masses);
    }
    for_each_item(static_cast<int>(items.size()), settings_.threads, [&](int i) {
      const Item& item = items[static_cast<std::size_t>(i)];
      std::vector<FilterMatrix> matrices;
      for (const std::size_t p : item.poses) matrices.push_back(read_matrix(poses_[p]));
      const CoefficientLayout layout = layout_of(item.coder, item.poses.front());
      auto energies = coefficient_energies(matrices, layout);
      for (std::size_t k = 0; k < item.poses.size(); ++k)
        weights_.energies.at(item.coder)
            .set_measured(item.poses[k], layout, std::move(energies[k]), poses_[item.poses[k]].masses);
      advance(progress);
    });
  }

  /// Returns the chunk of a layer's block, or nullopt if none of its samples has a texture.
  std::optional<ChunkToCode> chunk_of(const SampleGrid& grid, const InferredLayer& layer,
                                      const FieldBlock& block) const {
    ChunkToCode chunk;
    chunk.sizes = block.chunk_sizes();
    std::size_t count = 1;
    for (const std::size_t size : chunk.sizes) count *= size;
    chunk.textures.resize(count);
    chunk.seen_at.resize(count);
    std::set<std::size_t> poses;
    for (const std::size_t s : grid.samples_in(block)) {
      chunk.width = static_cast<std::size_t>(mapping_of_sample(object_, s).width);
      chunk.height = static_cast<std::size_t>(mapping_of_sample(object_, s).height);
      if (layer.textures[s].empty()) continue;
      const std::size_t number = block.chunk_sample(field_.samples[s].at);
      if (chunk.textures[number].empty()) chunk.textures[number] = layer.textures[s];
      chunk.seen_at[number].push_back(s);
      poses.insert(weights_.pose_of_sample[s]);
    }
    if (poses.empty()) return {};
    chunk.texel_weights.resize(chunk.width * chunk.height);
    for (const std::size_t pose : poses)
      for (std::size_t i = 0; i < chunk.texel_weights.size(); ++i) chunk.texel_weights[i] += poses_[pose].masses[i];
    chunk.weights = &weights_;
    return chunk;
  }

  /// Adds all matrices and textures to the checksum, in an order that does not depend on threads.
  void add_to(Checksum& checksum) const {
    for (const Pose& pose : poses_) checksum.update(pose.checksum.data(), pose.checksum.size());
    for (const auto& [name, text] : checksums_) {
      checksum.update(name.data(), name.size());
      checksum.update(text.data(), text.size());
    }
  }

 private:
  struct Pose {
    std::size_t first_sample;  // the sample that the file name of its matrix contains
    std::vector<std::size_t> samples;
    std::vector<float> masses;  // result of texel_masses()
    double pixels;              // number of covered pixels
    std::string checksum;
  };

  const TextureMapping& mapping_of(std::size_t pose) const {
    return mapping_of_sample(object_, poses_[pose].first_sample);
  }

  CoefficientLayout layout_of(const CoderAndSide& coder, std::size_t pose) const {
    const TextureMapping& mapping = mapping_of(pose);
    return {coder.first, static_cast<std::size_t>(mapping.width), static_cast<std::size_t>(mapping.height),
            coder.second};
  }

  /// Returns groups of poses that have the same texture coordinates and the same view of the object. The poses of a
  /// group differ only in occlusion.
  std::vector<std::vector<std::size_t>> alike_poses() const {
    std::vector<glm::dmat4> object_to_clip;
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t p = 0; p < poses_.size(); ++p) {
      const InferredSample& sample = field_.samples[poses_[p].first_sample];
      const auto moved = sample.object_to_world.find(object_.name);
      object_to_clip.push_back(moved == sample.object_to_world.end() ? sample.world_to_clip
                                                                     : sample.world_to_clip * moved->second);
      const auto group = std::find_if(groups.begin(), groups.end(), [&](const std::vector<std::size_t>& poses) {
        const std::size_t first = poses.front();
        return &mapping_of(first) == &mapping_of(p) && object_to_clip[first] == object_to_clip[p];
      });
      if (group == groups.end()) groups.push_back({p});
      else group->push_back(p);
    }
    return groups;
  }

  /// Returns, for each pose, the poses whose measured energies it uses. These are either the pose itself or some
  /// similar poses.
  std::vector<std::vector<std::size_t>> measured_of_poses() const {
    std::vector<std::vector<std::size_t>> result(poses_.size());
    for (const std::vector<std::size_t>& poses : alike_poses()) {
      std::vector<std::vector<float>> masses;
      for (const std::size_t p : poses)
        masses.push_back(cell_sums(static_cast<std::size_t>(mapping_of(p).width), poses_[p].masses));
      std::vector<std::size_t> measured;
      for (const std::size_t k : poses_to_measure(masses)) measured.push_back(poses[k]);
      for (const std::size_t p : poses) {
        const bool is_measured = std::find(measured.begin(), measured.end(), p) != measured.end();
        result[p] = is_measured ? std::vector{p} : measured;
      }
    }
    return result;
  }

  FilterMatrix read_matrix(const Pose& pose) const {
    const std::string path = settings_.folder + "/" + matrix_name(field_.samples[pose.first_sample], object_);
    FilterMatrix matrix = read_filter_matrix(path);
    const TextureMapping& mapping = mapping_of_sample(object_, pose.first_sample);
    if (matrix.texture_width != mapping.width || matrix.texture_height != mapping.height)
      refuse_file(path, fmt::format("is for a texture of {} x {} texels, but the manifest's mapping has {} x {}",
                                    matrix.texture_width, matrix.texture_height, mapping.width, mapping.height));
    return matrix;
  }

  /// Returns the result of layer_shares() for a sample.
  std::vector<std::vector<float>> shares_of(std::size_t sample, const FilterMatrix& matrix) {
    std::vector<std::vector<float>> radiances;
    for (const InferredLayer& layer : object_.layers) {
      const std::string& name = layer.textures[sample];
      radiances.push_back(name.empty() ? std::vector<float>(3 * static_cast<std::size_t>(matrix.layout().texel_count))
                                       : first_read(sample, name).texels);
    }
    std::vector<const std::vector<float>*> layers;
    for (const std::vector<float>& radiance : radiances) layers.push_back(&radiance);
    return layer_shares(matrix, layers);
  }

  InferredTexture first_read(std::size_t sample, const std::string& name) {
    const TextureMapping& mapping = mapping_of_sample(object_, sample);
    InferredTexture texture = read_texture_of(settings_.folder, name, static_cast<std::size_t>(mapping.width),
                                              static_cast<std::size_t>(mapping.height));
    Checksum checksum;
    update(checksum, texture.texels);
    const std::lock_guard lock(mutex_);
    checksums_[name] = checksum.text();
    return texture;
  }

  void advance(Progress* progress) {
    const std::lock_guard lock(mutex_);
    progress_advance(progress, 0);
  }

  const FieldSourceSettings& settings_;
  const InferredManifest& field_;
  const InferredObject& object_;
  ObjectWeights& weights_;
  std::vector<Pose> poses_;
  std::mutex mutex_;                              // protects progress and checksums_
  std::map<std::string, std::string> checksums_;  // checksums of textures, by name
};

void read_object(const FieldSourceSettings& settings, const InferredManifest& field, std::size_t number,
                 Progress* progress, Checksum& checksum, FieldSource& source) {
  const InferredObject& object = field.objects[number];
  const SampleGrid& grid = source.description.grid;
  source.weights.push_back(std::make_unique<ObjectWeights>());
  if (object.layers.empty()) return;
  ObjectReading reading(settings, field, object, *source.weights.back());
  reading.find_shares(progress);
  reading.find_energies(progress);
  reading.add_to(checksum);
  std::size_t texels = 1;
  for (const TextureMapping& mapping : object.mappings)
    texels = std::max(texels, static_cast<std::size_t>(mapping.width) * static_cast<std::size_t>(mapping.height));
  const std::size_t samples_max = std::max<std::size_t>(1, TextureChunkFormat::kTexelsMax / 2 / texels);
  // Spreads the first samples of the objects evenly over the side of a block.
  const int first = settings.stagger ? static_cast<int>(number * static_cast<std::size_t>(settings.block) /
                                                        std::max<std::size_t>(1, field.objects.size()))
                                     : 0;
  for (std::size_t l = 0; l < object.layers.size(); ++l) {
    const InferredLayer& layer = object.layers[l];
    PackedLayer packed{
        number,
        layer.name,
        field_blocks(field, grid, object.mapping_of_sample, layer.textures, {settings.block, first, samples_max}),
        {}};
    for (std::size_t s = 0; s < layer.textures.size(); ++s)
      if (layer.textures[s].empty()) packed.unseen.push_back(static_cast<int>(s));
    for (std::size_t b = 0; b < packed.blocks.size(); ++b) {
      if (packed.blocks[b].varying.size() > ParameterPyramid::kDimensionsMax)
        throw Error(ErrorCode::kInput, fmt::format("layer '{}' of object '{}' varies with {} parameters, expected at "
                                                   "most {}",
                                                   layer.name, object.name, packed.blocks[b].varying.size(),
                                                   ParameterPyramid::kDimensionsMax));
      auto chunk = reading.chunk_of(grid, layer, packed.blocks[b]);
      if (!chunk) continue;
      chunk->layer = source.description.layers.size();
      chunk->block = b;
      chunk->object = number;
      chunk->layer_of_object = l;
      source.chunks.push_back(std::move(*chunk));
    }
    source.description.layers.push_back(std::move(packed));
  }
}

std::vector<float> finest_gamma_coded(const InferredTexture& texture) {
  std::vector<float> values(3u * static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height));
  std::transform(texture.texels.begin(), texture.texels.begin() + std::ssize(values), values.begin(),
                 [](float radiance) { return gamma_coded(std::min(1.0f, radiance)); });
  return values;
}

std::string geometry_against_output(const FieldSourceSettings& settings, const std::string& named) {
  if (!fs::path(named).is_relative()) return named;
  const fs::path geometry = fs::absolute(settings.folder + "/" + named).lexically_normal();
  if (settings.has_absolute_geometry) return geometry.string();
  const fs::path parent = fs::path(settings.output).parent_path();
  return geometry.lexically_relative(fs::absolute(parent.empty() ? "." : parent).lexically_normal()).string();
}

}  // namespace

FieldSource read_field_source(const FieldSourceSettings& settings, Progress* progress) {
  const std::string manifest_path = settings.folder + "/" + kInferredManifestName;
  InferredManifest field = read_inferred_manifest(manifest_path);
  FieldSource source;
  source.folder = settings.folder;
  source.values = 3.0 * field.width * field.height * static_cast<double>(field.samples.size());
  try {
    source.description.grid = sample_grid(field.samples);
  } catch (const Error& error) {
    refuse_file(manifest_path, error.what());
  }
  Checksum checksum;
  for (std::size_t k = 0; k < field.objects.size(); ++k) read_object(settings, field, k, progress, checksum, source);
  for (InferredObject& object : field.objects) object.layers.clear();
  field.geometry_file = geometry_against_output(settings, field.geometry_file);
  source.description.field = std::move(field);
  source.checksum = checksum.text();
  return source;
}

ChunkSource read_chunk_source(const FieldSource& field, const ChunkToCode& chunk) {
  ChunkSource source;
  source.width = chunk.width;
  source.height = chunk.height;
  source.sizes = chunk.sizes;
  source.texel_weights = chunk.texel_weights;
  source.textures.resize(chunk.textures.size());
  for (std::size_t i = 0; i < chunk.textures.size(); ++i)
    if (!chunk.textures[i].empty())
      source.textures[i] =
          finest_gamma_coded(read_texture_of(field.folder, chunk.textures[i], chunk.width, chunk.height));
  // An invisible texture is a copy of a neighbouring sample's texture, because repeated textures cost no bits.
  const auto first =
      std::find_if(source.textures.begin(), source.textures.end(), [](const auto& t) { return !t.empty(); });
  MULTUM_CHECK(first != source.textures.end());
  const std::vector<float>* last = &*first;
  for (std::vector<float>& texture : source.textures) {
    if (texture.empty()) texture = *last;
    last = &texture;
  }
  return source;
}

}  // namespace multum
