// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packing/packing_journal.h"

#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/decoder/byte_reader.h"

namespace multum {
namespace {

std::vector<std::uint8_t> record_of(std::size_t chunk, double lambda, const ChosenChunk& chosen) {
  const ChunkSettings& settings = chosen.settings;
  ByteWriter writer;
  writer.number(chunk);
  writer.fixed(std::bit_cast<std::uint64_t>(lambda), 8);
  writer.byte(static_cast<std::uint8_t>(settings.coder));
  writer.number(settings.side);
  writer.number(settings.levels.size());
  writer.number(settings.levels.empty() ? 0 : settings.levels.front().size());
  for (const ParameterPyramid::Halvings& level : settings.levels) writer.bytes(level);
  writer.number(settings.basis_images);
  writer.byte(static_cast<std::uint8_t>((settings.linear ? 1 : 0) | (settings.open_loop ? 2 : 0)));
  writer.fixed(std::bit_cast<std::uint64_t>(settings.lambda), 8);
  writer.fixed(std::bit_cast<std::uint64_t>(chosen.chunk.error), 8);
  writer.bytes(chosen.chunk.bytes);
  return writer.written();
}

struct Record {
  std::size_t chunk = 0;
  double lambda = 0.0;
  ChosenChunk chosen;
};

std::optional<Record> read_record(std::span<const std::uint8_t> bytes) {
  ByteReader reader(bytes);
  const std::uint64_t most = bytes.size();
  Record record;
  ChunkSettings& settings = record.chosen.settings;
  record.chunk = reader.number(std::uint64_t{1} << 40);
  record.lambda = std::bit_cast<double>(reader.fixed(8));
  settings.coder = reader.byte() == 0 ? ImageCoder::kDct : ImageCoder::kWavelet;
  settings.side = reader.number(most + TextureChunkFormat::kSideMax);
  settings.levels.resize(reader.number(ParameterPyramid::kLevelsMax));
  const std::size_t dimensions = reader.number(ParameterPyramid::kDimensionsMax);
  for (ParameterPyramid::Halvings& level : settings.levels) {
    const auto halvings = reader.bytes(dimensions);
    level.assign(halvings.begin(), halvings.end());
  }
  settings.basis_images = reader.number(TextureChunkFormat::kBasisMax);
  const std::uint8_t flags = reader.byte();
  settings.linear = (flags & 1) != 0;
  settings.open_loop = (flags & 2) != 0;
  settings.lambda = std::bit_cast<double>(reader.fixed(8));
  record.chosen.chunk.error = std::bit_cast<double>(reader.fixed(8));
  const auto rest = reader.bytes(reader.left());
  record.chosen.chunk.bytes.assign(rest.begin(), rest.end());
  if (reader.failed()) return {};
  return record;
}

}  // namespace

std::unique_ptr<PackingJournal> PackingJournal::open(const std::string& output, const std::string& key, bool resume) {
  std::unique_ptr<PackingJournal> journal(new PackingJournal);
  journal->journal_ =
      RecordJournal::open(output, "chunks", key, resume, [&](RecordFile::Bytes bytes, const RecordFile::Place&) {
        auto record = read_record(bytes);
        if (record) journal->found_[{record->chunk, record->lambda}] = std::move(record->chosen);
        return record.has_value();
      });
  return journal->journal_ != nullptr ? std::move(journal) : nullptr;
}

std::optional<ChosenChunk> PackingJournal::find(std::size_t chunk, double lambda) const {
  const auto found = found_.find({chunk, lambda});
  if (found == found_.end()) return {};
  return found->second;
}

void PackingJournal::add(std::size_t chunk, double lambda, const ChosenChunk& chosen) {
  journal_->add({record_of(chunk, lambda, chosen)});
}

}  // namespace multum
