// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/field_description.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/decoder/byte_reader.h"
#include "host/fields/codec/decoder/parameter_pyramid.h"
#include "host/fields/inferred/manifest_json.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/leading_number.h"

namespace multum {
namespace {

using nlohmann::json;

constexpr std::uint64_t kTextBytesMax = std::uint64_t{1} << 26;
constexpr std::size_t kNumbersMax = std::size_t{1} << 24;  // enough for the matrices of ten objects at 100,000 samples
constexpr int kBlockDimensionsMax = static_cast<int>(ParameterPyramid::kDimensionsMax);

[[noreturn]] void refuse_description(const std::string& what) { throw Error(ErrorCode::kInput, what); }

// The keys of a mapping that describe how it was found. Players do not need these keys.
constexpr std::array kFoundKeys = {"stretchMax", "stretchRounds", "visiblePixels", "degeneratePixels"};

// Replaces each fraction by the shortest decimal that gives the same single-precision number.
void round_to_singles(json& value) {
  if (value.is_structured()) {
    for (json& child : value) round_to_singles(child);
  } else if (value.is_number_float()) {
    const double shortest = leading_number(fmt::format("{}", static_cast<float>(value.get<double>()))).value();
    if (shortest == std::floor(shortest) && std::abs(shortest) < 1e6) value = static_cast<int>(shortest);
    else value = shortest;
  }
}

// Returns the index of `value` in `list`. Appends `value` if it is new.
template <typename Value>
int index_in(std::vector<Value>& list, const Value& value) {
  const auto found = std::find(list.begin(), list.end(), value);
  if (found != list.end()) return static_cast<int>(found - list.begin());
  list.push_back(value);
  return static_cast<int>(list.size()) - 1;
}

json layer_json(const PackedLayer& layer) {
  json blocks = json::array();
  for (const FieldBlock& block : layer.blocks) blocks.push_back({block.begin, block.size, block.varying});
  return {{"name", layer.name}, {"blocks", blocks}, {"unseen", layer.unseen}};
}

json description_json(const FieldDescription& description) {
  json object = scene_json(description.field);
  round_to_singles(object);
  std::vector<json> views, moves;
  for (json& sample : object["samples"])
    sample = {sample["name"], sample["at"], index_in(views, sample["worldToClip"]),
              index_in(moves, sample["objectToWorld"])};
  object["views"] = views;
  object["moves"] = moves;
  for (json& entry : object["objects"]) {
    for (json& mapping : entry["mappings"])
      for (const char* key : kFoundKeys) mapping.erase(key);
    entry["layers"] = json::array();
  }
  for (const PackedLayer& layer : description.layers)
    object["objects"][layer.object]["layers"].push_back(layer_json(layer));
  return object;
}

std::string inflated(std::span<const std::uint8_t> bytes) {
  ByteReader reader(bytes);
  const std::uint64_t length = reader.number(kTextBytesMax);
  if (reader.failed()) refuse_description("does not state how long it is");
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

// Converts the description to the form that scene_from() reads. Returns the layers of each object.
std::vector<json> expand(json& description) {
  const std::vector<json> views = description.at("views"), moves = description.at("moves");
  std::size_t numbers = 0;  // how many numbers all samples have; the description stores shared numbers only once
  for (json& sample : description.at("samples")) {
    const json& view = views.at(index_of(sample.at(2), "the view of a sample"));
    const json& move = moves.at(index_of(sample.at(3), "the moves of a sample"));
    numbers += view.size();
    for (const json& matrix : move) numbers += std::max<std::size_t>(matrix.size(), 1);
    if (numbers > kNumbersMax) refuse_description("describes more positions of moving objects than a field can store");
    sample = {{"name", sample.at(0)}, {"at", sample.at(1)}, {"worldToClip", view}, {"objectToWorld", move}};
  }
  std::vector<json> layers;
  for (json& object : description.at("objects")) {
    for (json& mapping : object.at("mappings"))
      for (const char* key : kFoundKeys) mapping[key] = 0;
    layers.push_back(std::exchange(object.at("layers"), json::array()));
  }
  return layers;
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
  if (count != field.samples.size()) refuse_description("has blocks that do not cover all samples");
  for (const int sample : layer.unseen)
    if (sample < 0 || sample >= std::ssize(field.samples)) refuse_description("names an unknown sample");
  if (!std::is_sorted(layer.unseen.begin(), layer.unseen.end())) refuse_description("has samples out of order");
  return layer;
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
  const std::string text = json_text(description_json(description));
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
    if (holds_nul(text)) refuse_description("contains a NUL in a text");
    json object = json::parse(text);
    const std::vector<json> layers = expand(object);
    result.field = scene_from(object);
    result.grid = sample_grid(result.field.samples);
    for (std::size_t k = 0; k < layers.size(); ++k)
      for (const json& layer : layers[k]) result.layers.push_back(layer_from(layer, k, result.field, result.grid));
  } catch (const Error& error) {
    refuse(error.what());
  } catch (const json::exception& error) {
    refuse(std::string("is damaged: ") + error.what());
  } catch (const std::out_of_range&) {
    refuse("names an unknown view");
  }
  return result;
}

}  // namespace multum
