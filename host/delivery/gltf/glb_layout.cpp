// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/gltf/glb_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <vector>

#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_file.h"

namespace multum {
namespace {

constexpr std::uint64_t kAlignment = 16;
constexpr std::size_t kChunkAlignment = 4;
constexpr std::size_t kCopiedAtOnce = std::size_t{1} << 20;

struct ByteRange {
  std::uint64_t begin = 0, end = 0;
};

std::uint64_t aligned(std::uint64_t at) { return (at + kAlignment - 1) / kAlignment * kAlignment; }

// The new position of a buffer's bytes.
struct BufferPlace {
  bool is_merged = false;
  std::size_t index = 0;        // index of the new buffer
  std::uint64_t base = 0;       // offset of its first byte in the merged buffer
  std::vector<ByteRange> cuts;  // ordered ranges; lengths are multiples of kAlignment

  std::uint64_t moved(std::uint64_t offset) const {
    std::uint64_t cut = 0;
    for (const ByteRange& one : cuts)
      if (one.end <= offset) cut += one.end - one.begin;
    return base + offset - cut;
  }
};

class GlbLayout {
 public:
  GlbLayout(const GltfAsset& asset, GltfJson& json, const ViewContents& contents)
      : asset_(asset), json_(json), contents_(contents), places_(asset.buffers.size()) {}

  void lay_out() {
    choose_buffers();
    find_cuts();
    for (BufferPlace& place : places_) {
      if (!place.is_merged) continue;
      const auto number = static_cast<std::size_t>(&place - places_.data());
      place.base = length_ = aligned(length_);
      length_ += asset_.buffers[number]->size();
      for (const ByteRange& cut : place.cuts) length_ -= cut.end - cut.begin;
    }
    move_references(json_, "");
    place_contents();
    write_buffers();
  }

  bool has_bytes() const { return has_bytes_; }
  std::uint64_t length() const { return length_; }

  // Writes the bytes of the merged buffer in order, with the padding of a chunk.
  void write(OutputFile& file, Progress* progress) const {
    std::uint64_t at = 0;
    const auto pad_to = [&](std::uint64_t offset) {
      const std::string zeros(static_cast<std::size_t>(offset - at), '\0');
      write_or_throw(file, zeros.data(), zeros.size());
      at = offset;
    };
    const auto add = [&](const char* bytes, std::uint64_t count) {
      write_or_throw(file, bytes, static_cast<std::size_t>(count));
      at += count;
    };
    for (std::size_t b = 0; b < places_.size(); ++b) {
      if (!places_[b].is_merged) continue;
      pad_to(places_[b].base);
      const std::string& bytes = *asset_.buffers[b];
      std::uint64_t from = 0;
      for (const ByteRange& cut : places_[b].cuts) {
        add(bytes.data() + from, cut.begin - from);
        from = cut.end;
      }
      add(bytes.data() + from, bytes.size() - from);
      progress_advance(progress, 0);
    }
    for (const auto& [view, content] : contents_) {
      pad_to(offsets_.at(view));
      if (content.file.empty()) add(content.bytes.data(), content.bytes.size());
      else at += copy(content, file, progress);
    }
    pad_to((at + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment);
  }

 private:
  static std::uint64_t copy(const ViewContent& content, OutputFile& file, Progress* progress) {
    std::ifstream in(content.file, std::ios::binary);
    std::vector<char> bytes(kCopiedAtOnce);
    std::uint64_t count = 0;
    while (in.read(bytes.data(), static_cast<std::streamsize>(bytes.size())), in.gcount() > 0) {
      write_or_throw(file, bytes.data(), static_cast<std::size_t>(in.gcount()));
      count += static_cast<std::uint64_t>(in.gcount());
      progress_advance(progress, 0);
    }
    if (count != content.byte_count)
      throw Error(ErrorCode::kEnvironment,
                  fmt::format("{}: found {} bytes, expected {}", content.file, count, content.byte_count));
    return count;
  }

  // Merges all buffers that have bytes. Buffers with additional properties remain separate.
  void choose_buffers() {
    has_bytes_ = !contents_.empty() || std::any_of(asset_.buffers.begin(), asset_.buffers.end(),
                                                   [](const auto& buffer) { return buffer.has_value(); });
    std::size_t next = has_bytes_ ? 1 : 0;
    bool is_first = true;
    for (std::size_t b = 0; b < places_.size(); ++b) {
      const GltfJson& buffer = asset_.array("buffers").at(b);
      const bool has_more = buffer.contains("extensions") || buffer.contains("extras") || buffer.contains("name");
      places_[b].is_merged = asset_.buffers[b].has_value() && (is_first || !has_more);
      if (places_[b].is_merged && is_first) {
        is_first = false;
        head_ = buffer;
      }
      places_[b].index = places_[b].is_merged ? 0 : next++;
    }
  }

  // Calls use(object) for all objects that refer to buffer bytes, which are buffer views and similar objects of
  // extensions.
  template <typename Use>
  static void for_each_reference(GltfJson& value, const Use& use) {
    if (value.is_object() && unsigned_at(value, "buffer")) use(value);
    if (value.is_structured())
      for (GltfJson& child : value) for_each_reference(child, use);
  }

  void find_cuts() {
    std::vector<std::vector<ByteRange>> claimed(places_.size());
    bool is_clear = true;  // true if all used ranges are known
    std::size_t view = 0;
    const auto claim = [&](const GltfJson& reference) {
      const std::uint64_t buffer = *unsigned_at(reference, "buffer");
      const auto length = unsigned_at(reference, "byteLength");
      is_clear = is_clear && length && buffer < places_.size();
      if (!is_clear) return;
      const std::uint64_t offset = unsigned_at(reference, "byteOffset").value_or(0);
      claimed[buffer].push_back({offset, offset + *length});
    };
    for (auto& [key, value] : json_.items()) {
      if (key == "extras") continue;
      if (key != "bufferViews") for_each_reference(value, claim);
      else
        for (GltfJson& one : value)
          if (!contents_.contains(view++)) for_each_reference(one, claim);
    }
    if (!is_clear) return;
    for (const auto& [index, content] : contents_) {
      if (index >= asset_.array("bufferViews").size()) continue;
      const GltfJson& old = asset_.array("bufferViews").at(index);
      const std::size_t buffer = asset_.index(old, "buffer", "buffers");
      const std::uint64_t offset = unsigned_at(old, "byteOffset").value_or(0);
      if (places_[buffer].is_merged) cut_unclaimed({offset, offset + *unsigned_at(old, "byteLength")}, claimed, buffer);
    }
    for (BufferPlace& place : places_)
      std::sort(place.cuts.begin(), place.cuts.end(),
                [](const ByteRange& a, const ByteRange& b) { return a.begin < b.begin; });
  }

  void cut_unclaimed(ByteRange range, std::vector<std::vector<ByteRange>>& claimed, std::size_t buffer) {
    std::vector<ByteRange> in_use;
    for (const ByteRange& one : claimed[buffer])
      if (one.begin < range.end && range.begin < one.end) in_use.push_back(one);
    std::sort(in_use.begin(), in_use.end(), [](const ByteRange& a, const ByteRange& b) { return a.begin < b.begin; });
    in_use.push_back({range.end, range.end});
    for (const ByteRange& one : in_use) {
      if (one.begin > range.begin) {
        const std::uint64_t length = (one.begin - range.begin) / kAlignment * kAlignment;
        if (length > 0) places_[buffer].cuts.push_back({range.begin, range.begin + length});
      }
      range.begin = std::max(range.begin, one.end);
    }
    claimed[buffer].push_back(range);  // if two views share a range, it is cut only once
  }

  void move_references(GltfJson& value, const std::string& key) {
    if (key == "extras") return;
    if (value.is_object() && unsigned_at(value, "buffer") && *unsigned_at(value, "buffer") < places_.size()) {
      const BufferPlace& place = places_[*unsigned_at(value, "buffer")];
      value["buffer"] = place.index;
      const std::uint64_t offset = unsigned_at(value, "byteOffset").value_or(0);
      const std::uint64_t after = place.is_merged ? place.moved(offset) : offset;
      if (after != 0 || value.contains("byteOffset")) value["byteOffset"] = after;
    }
    if (value.is_object())
      for (auto& [name, child] : value.items()) move_references(child, name);
    else if (value.is_array())
      for (GltfJson& child : value) move_references(child, "");
  }

  void place_contents() {
    for (const auto& [index, content] : contents_) {
      const std::uint64_t at = aligned(length_);
      GltfJson view = {{"buffer", 0}, {"byteOffset", at}, {"byteLength", content.byte_count}};
      GltfJson& old = json_["bufferViews"][index];
      for (const char* key : {"name", "extras"})
        if (old.contains(key)) view[key] = old[key];
      old = std::move(view);
      offsets_[index] = at;
      length_ = at + content.byte_count;
    }
  }

  void write_buffers() {
    GltfJson buffers = GltfJson::array();
    head_.erase("uri");
    head_["byteLength"] = length_;
    if (has_bytes_) buffers.push_back(head_);
    for (std::size_t b = 0; b < places_.size(); ++b) {
      if (places_[b].is_merged) continue;
      GltfJson buffer = asset_.array("buffers").at(b);
      if (asset_.buffers[b])
        buffer["uri"] = "data:application/octet-stream;base64," + encode_base64(*asset_.buffers[b]);
      buffers.push_back(std::move(buffer));
    }
    if (!buffers.empty()) json_["buffers"] = std::move(buffers);
  }

  const GltfAsset& asset_;
  GltfJson& json_;
  const ViewContents& contents_;
  std::vector<BufferPlace> places_;
  bool has_bytes_ = false;              // whether there is a merged buffer
  GltfJson head_ = GltfJson::object();  // the JSON object of the merged buffer
  std::map<std::size_t, std::uint64_t> offsets_;
  std::uint64_t length_ = 0;
};

std::string little_endian_32(std::initializer_list<std::uint64_t> values) {
  std::string bytes;
  for (const std::uint64_t value : values)
    for (int i = 0; i < 4; ++i) bytes += static_cast<char>((value >> (8 * i)) & 255);
  return bytes;
}

}  // namespace

std::uint64_t write_glb(const GltfAsset& asset, GltfJson json, const ViewContents& contents, const std::string& output,
                        Progress* progress) {
  GlbLayout layout(asset, json, contents);
  layout.lay_out();
  std::string text = json.dump();
  while (text.size() % kChunkAlignment != 0) text += ' ';
  const std::uint64_t binary = (layout.length() + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
  const std::uint64_t binary_chunk = layout.has_bytes() ? 8 + binary : 0;
  const std::uint64_t total = 12 + 8 + text.size() + binary_chunk + asset.other_chunks.size();
  if (total > std::numeric_limits<std::uint32_t>::max())
    asset.refuse(
        fmt::format("would become a file of {} bytes, expected less than 4 GiB, which is the limit of GLB", total));
  AtomicFile file(output);
  OutputFile bytes(file);
  const auto add = [&](const std::string& part) { write_or_throw(bytes, part.data(), part.size()); };
  add("glTF" + little_endian_32({2, total, text.size(), 0x4E4F534A}));
  add(text);
  if (layout.has_bytes()) {
    add(little_endian_32({binary, 0x004E4942}));
    layout.write(bytes, progress);
  }
  add(asset.other_chunks);
  bytes.close();
  file.commit();
  return total;
}

}  // namespace multum
