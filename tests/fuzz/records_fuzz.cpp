// SPDX-License-Identifier: Apache-2.0
// Fuzzes files of records (host/foundation/base/files/record_file.h): shares of a map, and the journals of exports and
// packings. The checksums of records are repaired, because a reader drops a record with a wrong one.
#include <cstring>
#include <filesystem>

#include "host/bakes/movmf/map_shard.h"
#include "host/delivery/export/fit_journal.h"
#include "host/fields/codec/packing/packing_journal.h"
#include "host/foundation/base/files/checksum.h"
#include "kernels/shared/one_lobe.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

enum Kind { kShare, kFits, kChunks };
constexpr unsigned kKinds = 3;
constexpr const char* kJournals[] = {"", "fits", "chunks"};
const std::string kKey = "key";
const MapShard kShard{1, 2};
constexpr int kLevels = 4, kWidth = 4, kRows = 3;
constexpr RowBytes kRowBytes = {64, 0, 16};
constexpr std::size_t kChunk = 7;
constexpr double kLambda = 0.25;

std::string output() { return fuzz::scratch_folder() + "/map.exr"; }
std::string path_of(unsigned kind) {
  return kind == kShare ? shard_path(output(), kShard) : partial_folder_of(output()) + "/" + kJournals[kind];
}

std::string with_checksums(std::string bytes) {
  std::size_t at = bytes.find('\n');
  if (at != std::string::npos) at = bytes.find('\n', at + 1);
  if (at == std::string::npos) return bytes;
  for (++at; at + RecordFile::kHeadBytes + RecordFile::kChecksumBytes <= bytes.size();) {
    std::uint64_t size = 0;
    std::memcpy(&size, bytes.data() + at, sizeof size);
    at += RecordFile::kHeadBytes;
    if (size > bytes.size() - at - RecordFile::kChecksumBytes) break;
    Checksum checksum;
    checksum.update(bytes.data() + at, size);
    bytes.replace(at + size, RecordFile::kChecksumBytes, checksum.text());
    at += size + RecordFile::kChecksumBytes;
  }
  return bytes;
}

void read_share() {
  RowRecords rows;
  const ShareFile file(output(), kShard, &kKey, rows);
  std::vector<std::uint8_t> bytes;
  for (int level = 0; level < kLevels; ++level) {
    const int count = rows.row_count(level, kRowBytes);
    if (count < kRows) throw Error(ErrorCode::kInput, "no rows");
    bytes.resize(static_cast<std::size_t>(kRows) * kRowBytes[0]);
    for (int row = 0; row + kRows <= count; row += kRows)
      for (const RowPart part : {RowPart::kLobes, RowPart::kStored}) rows.read(level, part, row, kRows, bytes.data());
  }
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  std::vector<std::string> seeds;
  const auto add = [&](unsigned kind) { seeds.push_back(static_cast<char>(kind) + file_bytes(path_of(kind))); };
  {
    ShareWriter share(path_of(kShare), kKey, "{\"width\":4}");
    const std::vector<std::uint8_t> lobes(kRowBytes[0] * kRows, 1), stored(kRowBytes[2] * kRows, 2);
    for (int level = 0; level < kLevels; ++level)
      share.add_rows({level, 0, kRows, 0, kRowBytes}, {lobes.data(), nullptr, stored.data()});
    share.commit();
  }
  add(kShare);
  if (const auto fits = FitJournal::open(output(), kKey)) {
    fits->add(1, 0, kWidth, kRows, std::vector<float>(MULTUM_ONE_LOBE_FITTED * kWidth * kRows, 0.5f));
    fits->leave();
  }
  add(kFits);
  if (const auto chunks = PackingJournal::open(output(), kKey, false)) {
    ChosenChunk chosen;
    chosen.settings.levels = {{1, 0}, {1, 1}};
    chosen.chunk.bytes = {1, 2, 3};
    chunks->add(kChunk, kLambda, chosen);
    chunks->leave();
  }
  add(kChunks);
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, kKinds);
  const std::string bytes = with_checksums(std::string(input.bytes));
  // Makes the hidden folder, which only multum may have made.
  if (input.kind != kShare) {
    std::filesystem::remove_all(partial_folder_of(output()));
    FitJournal::open(output(), kKey)->leave();
  }
  if (input.kind == kShare) fuzz::input_file("map.exr.shard-1-of-2", bytes);
  else fuzz::input_file((std::filesystem::path(partial_folder_of("map.exr")) / kJournals[input.kind]).c_str(), bytes);
  fuzz::may_refuse([&] {
    if (input.kind == kShare) {
      read_share();
      MULTUM_CHECK(has_shard(output(), kShard, kKey));
      return;
    }
    if (input.kind == kFits) {
      const auto journal = FitJournal::open(output(), kKey);
      std::vector<float> fitted;
      for (int level = 0; journal != nullptr && level < kLevels; ++level)
        if (journal->find(level, 0, kWidth, kRows, fitted)) {
          MULTUM_CHECK(fitted.size() == MULTUM_ONE_LOBE_FITTED * kWidth * kRows);
          return;
        }
      throw Error(ErrorCode::kInput, "no fit");
    }
    const auto journal = PackingJournal::open(output(), kKey, true);
    if (journal == nullptr || !journal->find(kChunk, kLambda)) throw Error(ErrorCode::kInput, "no chunk");
  });
  return 0;
}
