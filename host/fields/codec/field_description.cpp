// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/field_description.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/decoder/byte_reader.h"
#include "host/fields/codec/decoder/parameter_pyramid.h"
#include "host/fields/inferred/manifest_json.h"
#include "host/fields/inferred/matrix_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

using nlohmann::json;

constexpr std::uint64_t kTextBytesMax = std::uint64_t{1} << 26;
constexpr int kBlockDimensionsMax = static_cast<int>(ParameterPyramid::kDimensionsMax);

[[noreturn]] void refuse_description(const std::string& what) { throw Error(ErrorCode::kInput, what); }

// The shortest decimal that is read back as the same single.
json single_json(double value) {
  const double shortest = std::stod(fmt::format("{}", static_cast<float>(value)));
  if (shortest == std::floor(shortest) && std::abs(shortest) < 1e6) return static_cast<int>(shortest);
  return shortest;
}

json matrix_as_singles(const glm::dmat4& m) {
  json rows = matrix_json(m);
  for (json& row : rows)
    for (json& value : row) value = single_json(value.get<double>());
  return rows;
}

// Without what was found while it was made.
json mapping_as_singles(const TextureMapping& mapping) {
  json object = mapping;
  for (const char* name : {"stretchMax", "stretchRounds", "visiblePixels", "degeneratePixels"}) object.erase(name);
  for (const char* name : {"linear", "offset", "cut"})
    for (json& value : object[name]) value = single_json(value.get<double>());
  return object;
}

TextureMapping mapping_from(json object) {
  for (const char* name : {"stretchMax", "stretchRounds", "visiblePixels", "degeneratePixels"}) object[name] = 0;
  return object.get<TextureMapping>();
}

// The index of `value` in `list`, put there if it is new.
template <typename Value>
int index_in(std::vector<Value>& list, const Value& value) {
  const auto found = std::find(list.begin(), list.end(), value);
  if (found != list.end()) return static_cast<int>(found - list.begin());
  list.push_back(value);
  return static_cast<int>(list.size()) - 1;
}

json poses_json(const InferredManifest& field, json& description) {
  std::vector<json> views, moves;
  json samples = json::array();
  for (const InferredSample& sample : field.samples) {
    json moved = json::object();
    for (const auto& [name, matrix] : sample.object_to_world) moved[name] = matrix_as_singles(matrix);
    samples.push_back(
        {sample.name, sample.at, index_in(views, matrix_as_singles(sample.world_to_clip)), index_in(moves, moved)});
  }
  description["views"] = views;
  description["moves"] = moves;
  return samples;
}

json layer_json(const PackedLayer& layer) {
  json blocks = json::array();
  for (const FieldBlock& block : layer.blocks) blocks.push_back({block.begin, block.size, block.varying});
  return {{"name", layer.name}, {"blocks", blocks}, {"unseen", layer.unseen}};
}

json objects_json(const FieldDescription& description) {
  json objects = json::array();
  for (std::size_t k = 0; k < description.field.objects.size(); ++k) {
    const InferredObject& object = description.field.objects[k];
    json mappings = json::array(), layers = json::array();
    for (const TextureMapping& mapping : object.mappings) mappings.push_back(mapping_as_singles(mapping));
    for (const PackedLayer& layer : description.layers)
      if (layer.object == k) layers.push_back(layer_json(layer));
    objects.push_back({{"name", object.name},
                       {"mesh", object.mesh},
                       {"anisotropy", single_json(static_cast<double>(object.anisotropy))},
                       {"mappings", mappings},
                       {"mappingOfSample", object.mapping_of_sample},
                       {"layers", layers}});
  }
  return objects;
}

std::string inflated(std::span<const std::uint8_t> bytes) {
  ByteReader reader(bytes);
  const std::uint64_t length = reader.number(kTextBytesMax);
  if (reader.failed()) refuse_description("does not say how long it is");
  std::string text(length, '\0');
  auto written = static_cast<uLongf>(length);
  const auto packed = bytes.subspan(reader.position());
  const int state =
      uncompress(reinterpret_cast<Bytef*>(text.data()), &written, packed.data(), static_cast<uLong>(packed.size()));
  if (state != Z_OK || written != length) refuse_description("cannot be inflated");
  return text;
}

std::size_t index_of(const json& value, const char* what) {
  return static_cast<std::size_t>(json_integer_of(value, what, 0, INT32_MAX));
}

void read_samples(const json& description, InferredManifest& field) {
  std::vector<glm::dmat4> views;
  for (const json& view : description.at("views")) views.push_back(matrix_from_json(view));
  for (const json& entry : description.at("samples")) {
    InferredSample sample;
    sample.name = entry.at(0).get<std::string>();
    sample.at = json_ints_of(entry.at(1), "at");
    sample.world_to_clip = views.at(index_of(entry.at(2), "the view of a sample"));
    for (const auto& [name, matrix] :
         description.at("moves").at(index_of(entry.at(3), "the moves of a sample")).items())
      sample.object_to_world[name] = matrix_from_json(matrix);
    field.samples.push_back(std::move(sample));
  }
  check_samples(field);
}

FieldBlock block_from(const json& entry, const SampleGrid& grid) {
  FieldBlock block{json_ints_of(entry.at(0), "a block's begin"), json_ints_of(entry.at(1), "a block's size"), {}};
  for (const json& dimension : entry.at(2)) block.varying.push_back(index_of(dimension, "a block's dimension"));
  const std::size_t dimensions = grid.sizes.size();
  bool fits = block.begin.size() == dimensions && block.size.size() == dimensions &&
              std::ssize(block.varying) <= kBlockDimensionsMax;
  for (std::size_t d = 0; d < dimensions && fits; ++d) {
    const auto most = static_cast<int>(grid.sizes[d]);
    fits = block.begin[d] >= 0 && block.begin[d] < most && block.size[d] >= 1 && block.size[d] <= most - block.begin[d];
  }
  for (std::size_t i = 0; i < block.varying.size(); ++i)
    fits = fits && block.varying[i] < dimensions && (i == 0 || block.varying[i - 1] < block.varying[i]);
  if (!fits) refuse_description("has a block that is not in the grid");
  return block;
}

PackedLayer layer_from(const json& entry, std::size_t object, const InferredManifest& field, const SampleGrid& grid) {
  PackedLayer layer;
  layer.object = object;
  layer.name = entry.at("name").get<std::string>();
  layer.unseen = json_ints(entry, "unseen");
  std::vector<bool> covered(field.samples.size(), false);
  std::size_t count = 0;
  for (const json& block : entry.at("blocks")) {
    layer.blocks.push_back(block_from(block, grid));
    for (const std::size_t s : grid.samples_in(layer.blocks.back())) {
      if (covered[s]) refuse_description("has blocks that share a sample");
      covered[s] = true;
      ++count;
    }
  }
  if (count != field.samples.size()) refuse_description("has blocks that leave samples out");
  for (const int sample : layer.unseen)
    if (sample < 0 || sample >= std::ssize(field.samples)) refuse_description("names a sample that there is not");
  if (!std::is_sorted(layer.unseen.begin(), layer.unseen.end())) refuse_description("has samples out of order");
  return layer;
}

void read_objects(const json& description, FieldDescription& result) {
  InferredManifest& field = result.field;
  result.grid = sample_grid(field.samples);
  for (const json& entry : description.at("objects")) {
    InferredObject object;
    object.name = entry.at("name").get<std::string>();
    object.mesh = entry.at("mesh").get<std::string>();
    object.anisotropy = anisotropy_from_json(entry.at("anisotropy"));
    for (const json& mapping : entry.at("mappings")) object.mappings.push_back(mapping_from(mapping));
    object.mapping_of_sample = json_ints(entry, "mappingOfSample");
    check_mappings(field, object);
    for (const json& layer : entry.at("layers"))
      result.layers.push_back(layer_from(layer, field.objects.size(), field, result.grid));
    field.objects.push_back(std::move(object));
  }
}

}  // namespace

bool PackedLayer::is_seen(std::size_t sample) const {
  return !std::binary_search(unseen.begin(), unseen.end(), static_cast<int>(sample));
}

std::size_t PackedLayer::block_at(const std::vector<int>& at) const {
  const auto found = std::find_if(blocks.begin(), blocks.end(), [&](const FieldBlock& block) {
    for (std::size_t d = 0; d < at.size(); ++d)
      if (at[d] < block.begin[d] || at[d] >= block.begin[d] + block.size[d]) return false;
    return true;
  });
  MULTUM_CHECK(found != blocks.end());  // blocks cover the grid
  return static_cast<std::size_t>(found - blocks.begin());
}

std::vector<std::uint8_t> encode_description(const FieldDescription& description) {
  const InferredManifest& field = description.field;
  json object = scene_keys_json(field);
  object["objects"] = objects_json(description);
  object["samples"] = poses_json(field, object);
  const std::string text = json_text(object);
  std::vector<Bytef> packed(compressBound(static_cast<uLong>(text.size())));
  auto length = static_cast<uLongf>(packed.size());
  MULTUM_CHECK(compress2(packed.data(), &length, reinterpret_cast<const Bytef*>(text.data()),
                         static_cast<uLong>(text.size()), Z_BEST_COMPRESSION) == Z_OK);
  ByteWriter writer;
  writer.number(text.size());
  writer.bytes(std::span(packed).first(length));
  return writer.written();
}

FieldDescription decode_description(std::span<const std::uint8_t> bytes) {
  const auto refuse = [](const std::string& what) { throw Error(ErrorCode::kInput, "its description " + what); };
  FieldDescription result;
  try {
    const std::string text = inflated(bytes);
    if (holds_nul(text)) refuse_description("holds NUL in a text");
    const json object = json::parse(text);
    read_scene_keys(object, result.field);
    read_samples(object, result.field);
    read_objects(object, result);
  } catch (const Error& error) {
    refuse(error.what());
  } catch (const json::exception& error) {
    refuse(std::string("is damaged: ") + error.what());
  } catch (const std::out_of_range&) {
    refuse("names a view that there is not");
  }
  return result;
}

}  // namespace multum
