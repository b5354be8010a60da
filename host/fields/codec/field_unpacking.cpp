// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/field_unpacking.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "host/fields/codec/decoder/mip_levels.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/processes/parallel.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

std::size_t section_number(const PackedIndex& index, const PackedSection* section) {
  return static_cast<std::size_t>(section - index.sections().data());
}

/// Returns the samples of a block that have a texture, by their numbers in the chunk.
std::map<std::size_t, std::vector<std::size_t>> drawn_samples(const FieldDescription& description,
                                                              const PackedLayer& layer, const FieldBlock& block) {
  std::map<std::size_t, std::vector<std::size_t>> samples;
  for (const std::size_t s : description.grid.samples_in(block))
    if (layer.is_seen(s)) samples[block.chunk_sample(description.field.samples[s].at)].push_back(s);
  return samples;
}

MULTUM_VECTOR_CLONES void to_radiance(float* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = radiance_of(values[i]);
}

std::string coder_text(const TextureChunkFormat& format) {
  const std::string coder =
      format.coder == ImageCoder::kWavelet ? "wavelets" : fmt::format("{0} x {0} cosines", format.side);
  return format.basis.empty() ? fmt::format("{}, pyramid of {} levels", coder, format.levels.size())
                              : fmt::format("{}, basis of {} images", coder, format.basis.size());
}

}  // namespace

bool is_packed_field(const std::string& path) { return first_bytes(path, 4) == "MPTF"; }

PackedFieldFile::PackedFieldFile(const std::string& path) : path_(path), stream_(path) {
  if (!stream_.seekg(0, std::ios::end)) refuse_file(path, "cannot be read");
  size_ = static_cast<std::uint64_t>(std::streamoff(stream_.tellg()));
  read_index();
  const PackedSection* section = index_.find(SectionKind::kDescription, 0, 0);
  if (section == nullptr) refuse_file(path, "has no description");
  try {
    description_ = decode_description(this->section(section_number(index_, section)));
  } catch (const Error& refused) {
    const std::string what = refused.what();
    if (what.starts_with(path)) throw;
    refuse_file(path, what);
  }
}

std::vector<std::uint8_t> PackedFieldFile::bytes_at(std::uint64_t offset, std::uint64_t count) {
  std::vector<std::uint8_t> bytes(count);
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(offset));
  if (!stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count)))
    refuse_file(path_, fmt::format("cannot be read up to byte {}", offset + count));
  return bytes;
}

void PackedFieldFile::read_index() {
  std::string problem;
  const auto needed =
      PackedIndex::bytes_needed(bytes_at(0, std::min<std::uint64_t>(size_, PackedIndex::kHeadBytes)), problem);
  if (!needed) refuse_file(path_, "is " + problem);
  const auto index = PackedIndex::read(bytes_at(0, std::min<std::uint64_t>(size_, *needed)), problem);
  if (!index) refuse_file(path_, "is damaged: " + problem);
  index_ = *index;
  if (size_ == index_.file_bytes()) return;
  std::string where;
  for (const PackedSection& section : index_.sections())
    if (where.empty() && section.offset + section.length > size_)
      where = fmt::format(", cut within section {}", section_number(index_, &section));
  refuse_file(path_, fmt::format("has {} bytes, but its index states {}{}", size_, index_.file_bytes(), where));
}

std::string PackedFieldFile::section_name(std::size_t number) const {
  const PackedSection& section = index_.sections()[number];
  if (section.kind == static_cast<std::uint32_t>(SectionKind::kDescription))
    return fmt::format("section {} (description)", number);
  if (section.kind != static_cast<std::uint32_t>(SectionKind::kChunk) || section.layer >= description_.layers.size())
    return fmt::format("section {} (of kind {})", number, section.kind);
  const PackedLayer& layer = description_.layers[section.layer];
  return fmt::format("section {} (chunk: layer '{}' of object '{}', block {})", number, layer.name,
                     description_.field.objects[layer.object].name, section.block);
}

std::vector<std::uint8_t> PackedFieldFile::section(std::size_t number) {
  const PackedSection& section = index_.sections()[number];
  std::vector<std::uint8_t> bytes = bytes_at(section.offset, section.length);
  if (!is_intact(section, bytes)) refuse_file(path_, section_name(number) + " is damaged: its checksum differs");
  return bytes;
}

std::optional<std::size_t> PackedFieldFile::chunk_section(std::size_t layer, std::size_t block) const {
  const PackedSection* found =
      index_.find(SectionKind::kChunk, static_cast<std::uint32_t>(layer), static_cast<std::uint32_t>(block));
  const PackedLayer& described = description_.layers[layer];
  if (drawn_samples(description_, described, described.blocks[block]).empty()) return {};
  if (found == nullptr)
    refuse_file(path_, fmt::format("has no chunk for layer '{}' of object '{}', block {}", described.name,
                                   description_.field.objects[described.object].name, block));
  return section_number(index_, found);
}

void PackedFieldFile::check_head(std::size_t number, const TextureChunkFormat& format) const {
  const PackedSection& section = index_.sections()[number];
  const PackedLayer& described = description_.layers[section.layer];
  const FieldBlock& block = described.blocks[section.block];
  const InferredObject& object = description_.field.objects[described.object];
  bool fits = format.sizes == block.chunk_sizes();
  for (const auto& [texture, samples] : drawn_samples(description_, described, block))
    for (const std::size_t s : samples) {
      const TextureMapping& mapping = object.mappings[static_cast<std::size_t>(object.mapping_of_sample[s])];
      fits =
          fits && static_cast<int>(format.width) == mapping.width && static_cast<int>(format.height) == mapping.height;
    }
  if (!fits) refuse_file(path_, section_name(number) + " has texture sizes that differ from its description");
}

std::unique_ptr<TextureChunk> PackedFieldFile::decode_chunk(std::size_t number, std::span<const std::uint8_t> bytes,
                                                            const DecodingLimits& limits) const {
  std::string problem;
  std::unique_ptr<TextureChunk> chunk = TextureChunk::decode(bytes, problem, limits);
  if (!chunk) refuse_file(path_, section_name(number) + " is damaged: " + problem);
  if (chunk->was_cut_short())
    refuse_file(path_, section_name(number) + " is damaged: it ends before its last image is complete");
  check_head(number, chunk->format());
  return chunk;
}

std::unique_ptr<TextureChunk> PackedFieldFile::chunk(std::size_t layer, std::size_t block) {
  const auto number = chunk_section(layer, block);
  return number ? decode_chunk(*number, section(*number), {}) : nullptr;
}

std::vector<float> radiance_levels(const TextureChunk& chunk, std::size_t sample) {
  std::vector<float> finest = chunk.texture(sample);
  to_radiance(finest.data(), finest.size());
  return mip_levels(chunk.format().width, chunk.format().height, finest);
}

InferredTexture unpacked_texture(const TextureChunk& chunk, std::size_t sample, const std::string& provenance) {
  const TextureChunkFormat& format = chunk.format();
  InferredTexture texture{static_cast<int>(format.width), static_cast<int>(format.height),
                          radiance_levels(chunk, sample), provenance};
  for (float& value : texture.texels) value = std::min(value, 65504.0f);  // the largest 16-bit float
  round_to_half(texture.texels);
  return texture;
}

UnpackReport unpack_field(const std::string& path, const std::string& folder, int threads, Progress* progress) {
  PackedFieldFile file(path);
  const FieldDescription& description = file.description();
  InferredManifest manifest = description.field;
  const std::filesystem::path packed = std::filesystem::absolute(path).parent_path();
  if (std::filesystem::path(manifest.geometry_file).is_relative())
    manifest.geometry_file = (packed / manifest.geometry_file)
                                 .lexically_normal()
                                 .lexically_relative(std::filesystem::absolute(folder).lexically_normal())
                                 .string();
  const std::string manifest_path = folder + "/" + kInferredManifestName;
  std::error_code error;
  if (std::filesystem::exists(manifest_path, error))  // a manifest whose textures took hours is never overwritten
    throw Error(ErrorCode::kUsage, manifest_path + ": already exists; expected a folder without this file");
  make_folder(folder + "/textures");
  progress_start(progress, file.index().sections().size());
  progress_stage(progress, "unpack");
  UnpackReport report;
  const std::string provenance =
      fmt::format("{{\"unpackedFrom\": \"packed field of {} bytes\"}}", file.index().file_bytes());
  for (std::size_t l = 0; l < description.layers.size(); ++l) {
    const PackedLayer& layer = description.layers[l];
    InferredLayer unpacked{layer.name, std::vector<std::string>(manifest.samples.size())};
    for (std::size_t b = 0; b < layer.blocks.size(); ++b) {
      std::unique_ptr<TextureChunk> chunk;
      try {
        chunk = file.chunk(l, b);
      } catch (const Error& damaged) {
        report.damaged.emplace_back(damaged.what());
      }
      if (!chunk) continue;
      const auto drawn = drawn_samples(description, layer, layer.blocks[b]);
      std::vector<std::size_t> numbers;
      for (const auto& [number, samples] : drawn) {
        numbers.push_back(number);
        for (const std::size_t s : samples)
          unpacked.textures[s] = fmt::format("textures/{:03d}_{:04d}_{:04d}.exr", l, b, number);
      }
      for_each_item(static_cast<int>(numbers.size()), threads, [&](int i) {
        const std::size_t number = numbers[static_cast<std::size_t>(i)];
        write_inferred_texture(unpacked_texture(*chunk, number, provenance),
                               folder + "/" + unpacked.textures[drawn.at(number).front()]);
      });
      report.textures += numbers.size();
      report.chunks += 1;
      progress_advance(progress, 1);
    }
    manifest.objects[layer.object].layers.push_back(std::move(unpacked));
  }
  write_inferred_manifest(manifest, manifest_path);
  progress_finish(progress);
  return report;
}

std::vector<PackedFinding> verify_packed_field(const std::string& path) {
  PackedFieldFile file(path);
  std::vector<PackedFinding> findings;
  for (std::size_t i = 0; i < file.index().sections().size(); ++i) {
    const PackedSection& section = file.index().sections()[i];
    PackedFinding finding{true, file.section_name(i), fmt::format("{} bytes", section.length)};
    try {
      const auto& layers = file.description().layers;
      if (section.kind == static_cast<std::uint32_t>(SectionKind::kChunk) && section.layer < layers.size() &&
          section.block < layers[section.layer].blocks.size())
        file.chunk(section.layer, section.block);
      else file.section(i);
    } catch (const Error& damaged) {
      finding.passed = false;
      finding.detail = damaged.what();
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

std::string packed_field_facts(const PackedFieldFile& file) {
  using Json = nlohmann::ordered_json;
  const FieldDescription& description = file.description();
  const InferredManifest& field = description.field;
  Json json = {{"file", text_of_path(file.path())},
               {"representation", "packed field"},
               {"parameters", field.parameters},
               {"sizes", description.grid.sizes},
               {"samples", field.samples.size()},
               {"width", field.width},
               {"height", field.height},
               {"geometry", {{"name", text_of_path(field.geometry_file)}, {"sha256", field.geometry_hash}}},
               {"bytes", file.index().file_bytes()},
               {"objects", Json::array()},
               {"layers", Json::array()},
               {"sections", Json::array()}};
  for (const InferredObject& object : field.objects) json["objects"].push_back(object.name);
  for (const PackedLayer& layer : description.layers)
    json["layers"].push_back({{"object", field.objects[layer.object].name}, {"name", layer.name}});
  const std::vector<PackedSection>& sections = file.index().sections();
  for (std::size_t i = 0; i < sections.size(); ++i)
    json["sections"].push_back({{"name", file.section_name(i)}, {"bytes", sections[i].length}});
  return json_text(json);
}

std::string packed_field_text(const std::string& path) {
  PackedFieldFile file(path);
  const FieldDescription& description = file.description();
  const InferredManifest& field = description.field;
  const double raw = 3.0 * field.width * field.height * static_cast<double>(field.samples.size());
  const auto bytes = static_cast<double>(file.index().file_bytes());
  std::string text = fmt::format("file            {}\nrepresentation  packed field\n", path);
  text += fmt::format("samples         {} of {}, {} x {} pixels\n", field.samples.size(),
                      fmt::join(field.parameters, ", "), field.width, field.height);
  text += fmt::format("geometry        {}, SHA-256 {}\n", field.geometry_file, field.geometry_hash);
  text +=
      fmt::format("on disk         {} bytes, {:.1f}:1 of raw 24-bit frames\n", file.index().file_bytes(), raw / bytes);
  for (std::size_t i = 0; i < file.index().sections().size(); ++i) {
    const PackedSection& section = file.index().sections()[i];
    text += fmt::format("{:7} bytes   {}", section.length, file.section_name(i));
    if (section.kind == static_cast<std::uint32_t>(SectionKind::kChunk)) {
      const std::vector<std::uint8_t> chunk = file.section(i);
      ByteReader reader(chunk);
      std::string problem;
      const auto format = read_chunk_format(reader, problem);
      text +=
          format ? fmt::format(": {} x {}, {}", format->width, format->height, coder_text(*format)) : ": " + problem;
    }
    text += "\n";
  }
  return text;
}

}  // namespace multum
