// SPDX-License-Identifier: Apache-2.0
#include "host/codec/packing_journal.h"

#include <bit>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/base/error.h"
#include "host/base/files/checksum.h"
#include "host/codec/byte_writer.h"
#include "host/codec/decoder/byte_reader.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChecksumBytes = 16;  // of Checksum::text()

std::string checksum_of(std::span<const std::uint8_t> bytes) {
  Checksum checksum;
  checksum.update(bytes.data(), bytes.size());
  return checksum.text();
}

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
  std::unique_ptr<PartialFolder> folder = PartialFolder::take(output);
  if (folder == nullptr) return nullptr;
  return std::unique_ptr<PackingJournal>(new PackingJournal(std::move(folder), key, resume));
}

PackingJournal::PackingJournal(std::unique_ptr<PartialFolder> folder, const std::string& key, bool resume)
    : folder_(std::move(folder)) {
  if (const std::uint64_t bytes = resume ? read_chunks(key) : 0; bytes > 0) {
    std::error_code ignored;
    fs::resize_file(chunks_path(), bytes, ignored);
    return;
  }
  folder_->clear();
  std::ofstream out(chunks_path(), std::ios::binary);
  out << key << '\n';
  if (!out.flush())
    throw Error(ErrorCode::kEnvironment, chunks_path() + ": cannot be written: " + std::strerror(errno));
}

std::uint64_t PackingJournal::read_chunks(const std::string& key) {
  std::ifstream in(chunks_path(), std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line != key) return 0;
  std::uint64_t good = line.size() + 1;
  std::error_code error;
  const std::uint64_t size = fs::file_size(chunks_path(), error);
  while (!error && size - good >= 4 + kChecksumBytes) {
    std::uint8_t head[4];
    in.read(reinterpret_cast<char*>(head), sizeof head);
    const std::uint64_t length = ByteReader(head).fixed(4);
    if (!in || length > size - good - 4 - kChecksumBytes) break;
    std::vector<std::uint8_t> bytes(length);
    std::string checksum(kChecksumBytes, ' ');
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(length));
    in.read(checksum.data(), static_cast<std::streamsize>(checksum.size()));
    if (!in || checksum_of(bytes) != checksum) break;
    auto record = read_record(bytes);
    if (!record) break;
    found_[{record->chunk, record->lambda}] = std::move(record->chosen);
    good += 4 + length + kChecksumBytes;
  }
  return good;
}

std::optional<ChosenChunk> PackingJournal::find(std::size_t chunk, double lambda) const {
  const auto found = found_.find({chunk, lambda});
  if (found == found_.end()) return {};
  return found->second;
}

void PackingJournal::add(std::size_t chunk, double lambda, const ChosenChunk& chosen) {
  const std::vector<std::uint8_t> bytes = record_of(chunk, lambda, chosen);
  ByteWriter head;
  head.fixed(bytes.size(), 4);
  const std::string checksum = checksum_of(bytes);
  const std::lock_guard lock(mutex_);
  std::ofstream out(chunks_path(), std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(head.written().data()), 4);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.write(checksum.data(), static_cast<std::streamsize>(checksum.size()));
  if (!out.flush())
    throw Error(ErrorCode::kEnvironment, chunks_path() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace multum
