// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/pipeline/inference_pieces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>

#include "host/foundation/base/log.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

bool wants_layer(const AnimationObject& object, const AnimationLayer& layer) {
  return object.layers.empty() ||
         std::find(object.layers.begin(), object.layers.end(), layer.name) != object.layers.end();
}

// The points and samples of one layer in one block.
struct PointCounts {
  std::uint64_t points = 0, samples = 0;
};

std::vector<PointCounts> points_of_blocks(const ParameterizedScene& field, const AnimationLayer& layer) {
  std::vector<PointCounts> counts(static_cast<std::size_t>(field.grid().block_count()));
  for (const ParameterPoint& point : field.grid().points(layer)) {
    PointCounts& block = counts[static_cast<std::size_t>(point.block)];
    block.points += 1;
    block.samples += point.samples.size();
  }
  return counts;
}

// Returns the sum of the numbers of fitted pixels and solved texels. The result is a whole number, so that every
// machine divides the work in the same way. The number of a mapping's visible pixels counts each pose only once.
std::uint64_t weight(const TextureMapping& mapping, const PointCounts& counts, std::uint64_t poses) {
  const auto side = [](int texels) { return static_cast<std::uint64_t>(std::max(texels, 1)); };
  return mapping.visible_pixels * counts.samples / std::max<std::uint64_t>(poses, 1) +
         counts.points * side(mapping.width) * side(mapping.height) + 1;
}

InferredObject object_of(const ParameterizedScene& field, const ObjectMappings& mappings, std::size_t k) {
  const AnimationJob& job = field.job();
  InferredObject object;
  object.name = job.objects[k].name;
  object.mesh = job.objects[k].mesh;
  for (TextureMapping mapping : mappings[k]) {
    mapping.width = std::max(1, mapping.width);  // for invisible objects, whose width is 0
    mapping.height = std::max(1, mapping.height);
    object.mappings.push_back(mapping);
  }
  for (std::size_t s = 0; s < job.samples.size(); ++s)
    object.mapping_of_sample.push_back(field.grid().block_of(static_cast<int>(s)));
  object.anisotropy = static_cast<float>(job.objects[k].texture.anisotropy);
  for (const AnimationLayer& layer : job.layers)
    if (wants_layer(job.objects[k], layer))
      object.layers.push_back({layer.name, std::vector<std::string>(job.samples.size())});
  return object;
}

}  // namespace

ObjectMappings find_object_mappings(const ParameterizedScene& field) {
  const AnimationJob& job = field.job();
  ObjectMappings mappings(job.objects.size());
  for (std::size_t k = 0; k < job.objects.size(); ++k) {
    bool is_seen = false;
    for (int block = 0; block < field.grid().block_count(); ++block) {
      mappings[k].push_back(field.find_mapping(k, block));
      is_seen = is_seen || mappings[k].back().width > 0;
    }
    if (!is_seen)
      log_warning(job.path, fmt::format("no picture shows object '{}', so it gets no texture", job.objects[k].name));
  }
  return mappings;
}

std::vector<InferencePiece> inference_pieces(const ParameterizedScene& field, const ObjectMappings& mappings) {
  const AnimationJob& job = field.job();
  std::vector<InferencePiece> pieces;
  for (int block = 0; block < field.grid().block_count(); ++block)
    for (std::size_t k = 0; k < job.objects.size(); ++k)
      for (std::size_t l = 0; l < job.layers.size(); ++l)
        if (mappings[k][static_cast<std::size_t>(block)].width > 0 && wants_layer(job.objects[k], job.layers[l]))
          pieces.push_back({block, k, l});
  return pieces;
}

std::vector<std::vector<InferencePiece>> divide_pieces(const ParameterizedScene& field, const ObjectMappings& mappings,
                                                       int count) {
  const auto shares = static_cast<std::uint64_t>(count);
  std::vector<std::vector<PointCounts>> counts;  // [layer][block]
  for (const AnimationLayer& layer : field.job().layers) counts.push_back(points_of_blocks(field, layer));
  std::vector<std::uint64_t> poses(static_cast<std::size_t>(field.grid().block_count()));
  for (const AnimationPose& pose : field.poses()) ++poses[static_cast<std::size_t>(pose.block)];
  const std::vector<InferencePiece> all = inference_pieces(field, mappings);
  std::vector<std::uint64_t> ends;  // end of each piece: the sum of the weights up to and including the piece
  for (const InferencePiece& piece : all) {
    const auto block = static_cast<std::size_t>(piece.block);
    ends.push_back((ends.empty() ? 0 : ends.back()) +
                   weight(mappings[piece.object][block], counts[piece.layer][block], poses[block]));
  }
  std::vector<std::vector<InferencePiece>> divided(shares);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::uint64_t begin = i == 0 ? 0 : ends[i - 1];
    // Assigns the piece to the share that contains its middle. Rounding up keeps the last index below `shares`.
    divided[(begin + ends[i]) / 2 / (ends.back() / shares + 1)].push_back(all[i]);
  }
  return divided;
}

InferredManifest manifest_of(const ParameterizedScene& field, const AnimationInferSettings& settings,
                             const ObjectMappings& mappings, const std::string& geometry_hash,
                             const std::vector<TextureResult>& textures) {
  const AnimationJob& job = field.job();
  InferredManifest m;
  std::error_code error;
  const fs::path relative = fs::relative(job.geometry_file, settings.output, error);
  const bool is_absolute = settings.has_absolute_geometry || error || relative.empty();
  m.geometry_file = is_absolute ? fs::absolute(job.geometry_file).lexically_normal().string() : relative.string();
  m.geometry_hash = geometry_hash;
  m.uv_set = job.uv_set;
  m.width = job.width;
  m.height = job.height;
  m.supersampling = job.supersampling;
  for (const AnimationParameter& parameter : job.parameters) m.parameters.push_back(parameter.name);
  for (std::size_t s = 0; s < job.samples.size(); ++s)
    m.samples.push_back({job.samples[s].name, job.samples[s].at,
                         field.world_to_clip(field.pose_of(static_cast<int>(s))), job.samples[s].object_to_world});
  for (std::size_t k = 0; k < job.objects.size(); ++k) m.objects.push_back(object_of(field, mappings, k));
  for (const TextureResult& texture : textures)
    for (InferredLayer& layer : m.objects[texture.object].layers)
      if (layer.name == job.layers[texture.layer].name)
        for (const int sample : texture.samples) layer.textures[static_cast<std::size_t>(sample)] = texture.file;
  // Removes a layer from an object if the object is black in this layer in every sample.
  for (InferredObject& object : m.objects)
    std::erase_if(object.layers, [&](const InferredLayer& layer) {
      return std::all_of(layer.textures.begin(), layer.textures.end(), [](const auto& file) { return file.empty(); });
    });
  return m;
}

}  // namespace multum
