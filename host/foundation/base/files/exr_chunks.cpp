// SPDX-License-Identifier: Apache-2.0
// Layout of an OpenEXR file ("OpenEXR File Layout", openexr.com):
//
//   headers | positions of chunks (8 bytes each), by part, level, row and column | chunks, in any order
//   chunk:  [part]  tile x, tile y, level x, level y  size: 4 bytes each | data
//           [part]  y of its first row                size
//
// Only files with several parts have the field [part].
#include "host/foundation/base/files/exr_chunks.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/exr_survey.h"
#include "host/foundation/base/files/exr_unpack.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr char kHead[] = "the head of a chunk";
constexpr std::int64_t kMultiPartFlag = 0x1000, kTiledFlag = 0x200;

std::int64_t signed_word(ByteFile& file, std::int64_t position, const char* what) {
  return static_cast<std::int32_t>(file.little_endian(position, 4, what));
}

std::vector<ExrChannel> channels_of(ByteFile& file, const ExrAttribute& attribute) {
  std::vector<ExrChannel> channels;
  const std::string bytes = file.bytes(attribute.position, attribute.size, "an EXR header");
  for (std::size_t at = 0, end = bytes.find('\0'); end != at && end != std::string::npos; end = bytes.find('\0', at)) {
    const auto word = [&](std::size_t offset) {
      return static_cast<int>(
          signed_word(file, attribute.position + static_cast<std::int64_t>(end + 1 + offset), kHead));
    };
    channels.push_back({bytes.substr(at, end - at), word(0), word(8), word(12)});
    at = end + 17;
  }
  return channels;
}

std::int64_t floor_divided(std::int64_t x, std::int64_t by) { return x >= 0 ? x / by : -((by - 1 - x) / by); }

// Counts the multiples of `step` that are at least `begin` and less than `end`.
std::int64_t multiples(std::int64_t begin, std::int64_t end, std::int64_t step) {
  return floor_divided(end - 1, step) - floor_divided(begin - 1, step);
}

int level_side(int side, int level, bool rounds_up) {
  const std::int64_t wide = std::int64_t{side} + (rounds_up ? (std::int64_t{1} << level) - 1 : 0);
  return static_cast<int>(std::max<std::int64_t>(1, wide >> level));
}

int levels_of_side(int side, bool rounds_up) {
  int count = 1;
  while (level_side(side, count - 1, rounds_up) > 1) ++count;
  return count;
}

// The low four bits of `mode` select the levels, and the high four bits select the rounding of their sizes.
void add_levels(ExrPart& part, int mode) {
  constexpr int kOneLevel = 0, kMipmap = 1;
  const bool rounds_up = mode / 16 != 0;
  const int kind = mode % 16;
  const auto add = [&](int x, int y) {
    const int width = level_side(part.width, x, rounds_up), height = level_side(part.height, y, rounds_up);
    part.levels.push_back({x, y, width, height,
                           static_cast<int>((width + std::int64_t{part.chunk_width} - 1) / part.chunk_width),
                           static_cast<int>((height + std::int64_t{part.chunk_height} - 1) / part.chunk_height), 0});
  };
  if (kind == kOneLevel) return add(0, 0);
  if (kind == kMipmap) {
    for (int l = 0; l < levels_of_side(std::max(part.width, part.height), rounds_up); ++l) add(l, l);
    return;
  }
  for (int y = 0; y < levels_of_side(part.height, rounds_up); ++y)
    for (int x = 0; x < levels_of_side(part.width, rounds_up); ++x) add(x, y);
}

// Values of the header that is being read.
struct PartDraft {
  ExrPart part;
  std::string type;
  std::int64_t window[4] = {0, 0, -1, -1};
  std::int64_t tile_width = 0, tile_height = 0;
  int level_mode = 0;
};

ExrPart finished_part(const std::string& path, PartDraft draft, bool is_tiled) {
  ExrPart& part = draft.part;
  const auto& [x0, y0, x1, y1] = draft.window;
  constexpr std::int64_t kSideMax = std::int64_t{1} << 30;
  if (x1 < x0 || y1 < y0 || x1 - x0 >= kSideMax || y1 - y0 >= kSideMax)
    refuse_file(path, fmt::format("damaged EXR: found a data window from ({}, {}) to ({}, {}), expected at most 2^30 "
                                  "texels per side",
                                  x0, y0, x1, y1));
  part.x = static_cast<int>(x0);
  part.y = static_cast<int>(y0);
  part.width = static_cast<int>(x1 - x0 + 1);
  part.height = static_cast<int>(y1 - y0 + 1);
  part.is_tiled = is_tiled;
  if (exr_rows_per_chunk(part.compression) == 0)
    refuse_file(path, fmt::format("damaged EXR: found compression {}, expected 0 to {}", part.compression,
                                  exr_compression::kCount - 1));
  if (is_tiled && (draft.tile_width < 1 || draft.tile_height < 1 || draft.level_mode % 16 > 2))
    refuse_file(path, fmt::format("damaged EXR: found tiles of {} x {} and level mode {}, expected at least 1 x 1",
                                  draft.tile_width, draft.tile_height, draft.level_mode));
  part.chunk_width = is_tiled ? static_cast<int>(draft.tile_width) : part.width;
  part.chunk_height = is_tiled ? static_cast<int>(draft.tile_height) : exr_rows_per_chunk(part.compression);
  for (const ExrChannel& channel : part.channels)
    if (channel.type < ExrChannel::kUint || channel.type > ExrChannel::kFloat || channel.x_sampling < 1 ||
        channel.y_sampling < 1 || (is_tiled && (channel.x_sampling != 1 || channel.y_sampling != 1)))
      refuse_file(path, fmt::format("damaged EXR: found a channel of type {}, one sample per {} x {} texels; expected "
                                    "type 0 to 2{}",
                                    channel.type, channel.x_sampling, channel.y_sampling,
                                    is_tiled ? ", one sample per texel" : ""));
  add_levels(part, is_tiled ? draft.level_mode : 0);
  return std::move(part);
}

}  // namespace

ExrChunks::ExrChunks(const std::string& path, std::vector<int> first_levels, std::string damaged)
    : path_(path), first_levels_(std::move(first_levels)), damaged_(std::move(damaged)), file_(path) {
  read_headers();
  std::int64_t position = tables_begin_;
  for (const ExrPart& part : parts_) {
    std::int64_t count = 0;
    for (const ExrLevel& level : part.levels) count += std::int64_t{level.columns} * level.rows;
    if (count > (file_.size() - position) / 8)
      refuse_file(path_, fmt::format("{}: it ends at byte {}, expected {} chunks. {}", damaged_, file_.size(), count,
                                     kWriteAnew));
    position += 8 * count;
  }
  tables_end_ = position;
  position = tables_begin_;
  for (std::size_t i = 0; i < parts_.size(); ++i) read_table(i, position);
  check_overlaps();
}

void ExrChunks::read_headers() {
  const std::int64_t version = file_.little_endian(4, 4, "the EXR version");
  is_multi_part_ = (version & kMultiPartFlag) != 0;
  PartDraft draft;
  std::int64_t end = 8;
  const auto word = [&](const ExrAttribute& attribute, int index) {
    return signed_word(file_, attribute.position + 4 * index, "an EXR header");
  };
  const auto visit = [&](const ExrAttribute& attribute) {
    end = attribute.position + attribute.size;
    const std::string& name = attribute.name;
    if (name == "channels" && attribute.type == "chlist") draft.part.channels = channels_of(file_, attribute);
    else if (name == "compression" && attribute.size == 1)
      draft.part.compression = static_cast<int>(file_.little_endian(attribute.position, 1, "a compression"));
    else if (name == "dataWindow" && attribute.size == 16)
      for (int i = 0; i < 4; ++i) draft.window[i] = word(attribute, i);
    else if (name == "tiles" && attribute.size == 9) {
      draft.tile_width = word(attribute, 0);
      draft.tile_height = word(attribute, 1);
      draft.level_mode = static_cast<int>(file_.little_endian(attribute.position + 8, 1, "a level mode"));
    } else if (name == "name" || name == "type") {
      (name == "name" ? draft.part.name : draft.type) = file_.bytes(attribute.position, attribute.size, "a name");
    }
  };
  const auto end_part = [&] {
    const bool is_tiled = is_multi_part_ ? draft.type == "tiledimage" : (version & kTiledFlag) != 0;
    parts_.push_back(finished_part(path_, std::exchange(draft, {}), is_tiled));
    ++end;  // skips the empty name
  };
  walk_exr_headers(path_, file_, visit, end_part);
  if (parts_.empty()) refuse_file(path_, "damaged EXR: no header");
  tables_begin_ = is_multi_part_ ? end + 1 : end;
}

void ExrChunks::read_table(std::size_t index, std::int64_t& position) {
  ExrPart& part = parts_[index];
  const std::int64_t head_bytes = 4 * ((is_multi_part_ ? 1 : 0) + (part.is_tiled ? 4 : 1) + 1);
  std::size_t count = 0;
  for (ExrLevel& level : part.levels) {
    level.first_chunk = count;
    count += static_cast<std::size_t>(level.columns) * static_cast<std::size_t>(level.rows);
  }
  std::vector<unsigned char> table(8 * count);
  file_.read(position, static_cast<std::int64_t>(table.size()), table.data(), "the table of chunks");
  position += static_cast<std::int64_t>(table.size());
  part.chunks.resize(count);
  for (std::size_t chunk = 0; chunk < count; ++chunk) {
    std::uint64_t place = 0;
    for (std::size_t i = 8; i-- > 0;) place = place << 8 | table[8 * chunk + i];
    if (place == 0) refuse(index, chunk, "it was never written");
    if (place < static_cast<std::uint64_t>(tables_end_) ||
        place > static_cast<std::uint64_t>(file_.size() - head_bytes))
      refuse(index, chunk,
             fmt::format("the chunk table states that it starts at byte {}, expected {} to {}", place, tables_end_,
                         file_.size() - head_bytes));
    const auto begin = static_cast<std::int64_t>(place);
    const std::string head = file_.bytes(begin, head_bytes, kHead);
    std::vector<std::int64_t> words;
    for (std::int64_t at = begin; at < begin + head_bytes; at += 4) words.push_back(signed_word(file_, at, kHead));
    const ExrChunkArea is = area(index, chunk);
    std::vector<std::int64_t> expected;
    if (is_multi_part_) expected.push_back(static_cast<std::int64_t>(index));
    if (part.is_tiled) expected.insert(expected.end(), {is.tile_x, is.tile_y, is.level_x, is.level_y});
    else expected.push_back(std::int64_t{part.y} + is.y);
    if (!std::equal(expected.begin(), expected.end(), words.begin()))
      refuse(index, chunk, "another chunk is in its place");
    const std::int64_t size = words.back(), size_max = unpacked_bytes(index, chunk);
    const bool is_plain = part.compression == exr_compression::kNone;
    if (size < (is_plain ? size_max : 1) || size > size_max)
      refuse(index, chunk,
             is_plain ? fmt::format("it has {} bytes, expected {}", size, size_max)
                      : fmt::format("it has {} bytes, expected 1 to {}", size, size_max));
    if (size > file_.size() - begin - head_bytes)
      refuse(index, chunk, fmt::format("its {} bytes run past the end of the file", size));
    if (!may_unpack_exr(part.compression, static_cast<std::size_t>(size), static_cast<std::size_t>(size_max)))
      refuse(index, chunk, fmt::format("its {} bytes are too few for {}", size, size_max));
    part.chunks[chunk] = {begin + head_bytes, static_cast<std::int32_t>(size)};
  }
}

void ExrChunks::check_overlaps() const {
  struct Range {
    std::int64_t begin, end;
    std::uint32_t part, chunk;
  };
  std::vector<Range> ranges;
  for (std::size_t i = 0; i < parts_.size(); ++i)
    for (std::size_t k = 0; k < parts_[i].chunks.size(); ++k) {
      const ExrChunkPlace& place = parts_[i].chunks[k];
      ranges.push_back(
          {place.position, place.position + place.size, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k)});
    }
  std::sort(ranges.begin(), ranges.end(), [](const Range& a, const Range& b) { return a.begin < b.begin; });
  for (std::size_t i = 1; i < ranges.size(); ++i)
    if (ranges[i - 1].end > ranges[i].begin) refuse(ranges[i].part, ranges[i].chunk, "it overlaps another chunk");
}

ExrChunkArea ExrChunks::area(std::size_t part_index, std::size_t chunk) const {
  const ExrPart& part = parts_[part_index];
  const auto after = std::upper_bound(part.levels.begin(), part.levels.end(), chunk,
                                      [](std::size_t c, const ExrLevel& level) { return c < level.first_chunk; });
  const ExrLevel& level = *(after - 1);
  const std::size_t within = chunk - level.first_chunk;
  ExrChunkArea is{level.level_x,
                  level.level_y,
                  static_cast<int>(within % static_cast<std::size_t>(level.columns)),
                  static_cast<int>(within / static_cast<std::size_t>(level.columns)),
                  0,
                  0,
                  0,
                  0};
  is.x = is.tile_x * part.chunk_width;
  is.y = is.tile_y * part.chunk_height;
  is.width = std::min(part.chunk_width, level.width - is.x);
  is.height = std::min(part.chunk_height, level.height - is.y);
  return is;
}

std::int64_t ExrChunks::unpacked_bytes(std::size_t part_index, std::size_t chunk) const {
  const ExrPart& part = parts_[part_index];
  const ExrChunkArea is = area(part_index, chunk);
  std::int64_t bytes = 0;
  for (const ExrChannel& channel : part.channels) {
    const std::int64_t x = std::int64_t{part.x} + is.x, y = std::int64_t{part.y} + is.y;
    bytes += channel.bytes() * multiples(x, x + is.width, channel.x_sampling) *
             multiples(y, y + is.height, channel.y_sampling);
  }
  return bytes;
}

bool ExrChunks::can_unpack(std::size_t part) const { return can_unpack_exr(parts_[part].compression); }

const unsigned char* ExrChunks::packed_bytes(std::size_t part, std::size_t chunk) const {
  const ExrChunkPlace& place = parts_[part].chunks[chunk];
  const auto size = static_cast<std::size_t>(place.size);
  static thread_local std::vector<unsigned char> packed;
  if (packed.size() < size) packed.resize(size);
  file_.read(place.position, place.size, packed.data(), "a chunk");
  return packed.data();
}

void ExrChunks::unpack(std::size_t part, std::size_t chunk, std::vector<unsigned char>& unpacked) const {
  MULTUM_CHECK(can_unpack(part));
  const auto size = static_cast<std::size_t>(unpacked_bytes(part, chunk));
  if (unpacked.size() < size) unpacked.resize(size);
  const char* const wrong =
      unpack_exr(parts_[part].compression, packed_bytes(part, chunk),
                 static_cast<std::size_t>(parts_[part].chunks[chunk].size), unpacked.data(), size);
  if (wrong != nullptr) refuse(part, chunk, wrong);
}

void ExrChunks::check_all(int threads) const {
  for (std::size_t part = 0; part < parts_.size(); ++part) check_range(part, 0, parts_[part].chunks.size(), threads);
}

void ExrChunks::check_rows(std::size_t part, int first, int end, int threads) const {
  const ExrLevel& level = parts_[part].levels[0];
  const int height = parts_[part].chunk_height;
  MULTUM_CHECK(first >= 0 && first < end && end <= level.height);
  const auto columns = static_cast<std::size_t>(level.columns);
  check_range(part, static_cast<std::size_t>(first / height) * columns,
              static_cast<std::size_t>((end - 1) / height + 1) * columns, threads);
}

void ExrChunks::check_range(std::size_t part, std::size_t first, std::size_t end, int threads) const {
  constexpr int kChunksAtOnce = 16;
  if (!can_unpack(part) || parts_[part].compression == exr_compression::kNone) return;
  for_each_row_band(static_cast<int>(end - first), kChunksAtOnce, threads, [&](int, int band_first, int band_end) {
    for (int chunk = band_first; chunk < band_end; ++chunk) check(part, first + static_cast<std::size_t>(chunk));
  });
}

void ExrChunks::check(std::size_t part, std::size_t chunk) const {
  const std::int64_t size = unpacked_bytes(part, chunk);
  const std::int32_t packed_size = parts_[part].chunks[chunk].size;
  if (packed_size == size) return;  // the chunk is stored unpacked
  const char* const wrong = check_exr(parts_[part].compression, packed_bytes(part, chunk),
                                      static_cast<std::size_t>(packed_size), static_cast<std::size_t>(size));
  if (wrong != nullptr) refuse(part, chunk, wrong);
}

void ExrChunks::refuse(std::size_t part_index, std::size_t chunk, const std::string& what) const {
  const ExrPart& part = parts_[part_index];
  const ExrChunkArea is = area(part_index, chunk);
  std::string place = part.name.empty() ? "" : fmt::format("part {}, ", part.name);
  const int first_level = part_index < first_levels_.size() ? first_levels_[part_index] : 0;
  if (!part.is_tiled) place += fmt::format("rows {} to {}", is.y, is.y + is.height - 1);
  else if (is.level_x == is.level_y)
    place += fmt::format("level {}, tile ({}, {})", is.level_x + first_level, is.tile_x, is.tile_y);
  else place += fmt::format("level ({}, {}), tile ({}, {})", is.level_x, is.level_y, is.tile_x, is.tile_y);
  refuse_file(path_, fmt::format("{}: {}: {}. {}", damaged_, place, what, kWriteAnew));
}

}  // namespace multum
