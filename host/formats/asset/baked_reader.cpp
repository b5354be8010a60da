// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/baked_reader.h"

#include <ImfStringAttribute.h>
#include <ImfTiledInputPart.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <cstring>

#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/files/exr_survey.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr char kDamaged[] = "damaged baked file";

int thread_count(int threads) { return threads > 0 ? threads : processor_count(); }

// Copies one channel of a row of a tile. In the output, consecutive values are `stride` apart.
void put_row(const unsigned char* from, bool is_half, std::size_t width, float* to, std::size_t stride) {
  for (std::size_t x = 0; x < width; ++x) {
    if (is_half) {
      std::uint16_t bits = 0;
      std::memcpy(&bits, from + x * sizeof(bits), sizeof(bits));
      half value;
      value.setBits(bits);
      to[x * stride] = value;
    } else {
      std::memcpy(to + x * stride, from + x * sizeof(float), sizeof(float));
    }
  }
}

}  // namespace

// Complete rows of tiles in one level of a part.
struct BakedReader::TileRows {
  std::size_t part;
  int level;  // level of the map
  int width;
  int tile_first, tile_last;  // the rows of tiles
  int row_begin, row_end;     // the rows of texels in these tiles
  int tile_height;

  int count() const { return tile_last - tile_first + 1; }
};

BakedReader::BakedReader(const std::string& path, int threads, TexelCheck check)
    : path_(path), threads_(thread_count(threads)), check_(check) {
  check_exr_headers(path, "not a readable baked file");
  guarded([&] {
    stream_ = std::make_unique<ExrInputStream>(path);
    file_ = std::make_unique<Imf::MultiPartInputFile>(*stream_, threads_, false);  // expect() checks the tables
  });
}

void BakedReader::expect(const BakedHeader& header, std::vector<BakedPart> parts) {
  check_baked_parts(*file_, header, parts, path_);
  header_ = header;
  parts_ = std::move(parts);
  tile_size_ = static_cast<int>(file_->header(0).tileDescription().ySize);
  std::vector<int> first_levels;
  for (const BakedPart& part : parts_) first_levels.push_back(part.first_level);
  chunks_ = std::make_unique<ExrChunks>(path_, std::move(first_levels), kDamaged);
  row_checksums_ = std::make_unique<RowChecksums>(header_, parts_, tile_size_);
  const auto* stated = file_->header(0).findTypedAttribute<Imf::StringAttribute>(kRowChecksumsAttribute);
  const auto is_of_other_tiles = [&](const ExrPart& part) { return part.chunk_height != tile_size_; };
  if (stated == nullptr || !row_checksums_->take(stated->value()) ||
      std::any_of(chunks_->parts().begin(), chunks_->parts().end(), is_of_other_tiles))
    row_checksums_.reset();
}

void BakedReader::read_values(std::size_t part_index, int level, int first_row, int row_count, float* values) {
  const BakedPart& part = parts_[part_index];
  const int width = mip_level_size(header_.width, level), height = mip_level_size(header_.height, level);
  MULTUM_CHECK(part.has_level(level) && first_row >= 0 && row_count >= 0 && first_row + row_count <= height);
  if (row_count == 0) return;
  guarded([&] {
    if (row_checksums_ == nullptr && !is_content_checked_) check_content_hash();
    TileRows rows{part_index, level, width, 0, 0, 0, 0, chunks_->parts()[part_index].chunk_height};
    rows.tile_first = first_row / rows.tile_height;
    rows.tile_last = (first_row + row_count - 1) / rows.tile_height;
    rows.row_begin = rows.tile_first * rows.tile_height;
    rows.row_end =
        static_cast<int>(std::min<std::int64_t>(height, (rows.tile_last + 1) * std::int64_t{rows.tile_height}));
    if (rows.row_begin == first_row && rows.row_end == first_row + row_count) return read_tile_rows(rows, values);
    // Only whole tiles can be read. If they hold more rows than requested, they are read into a buffer first.
    const std::size_t row_values = static_cast<std::size_t>(width) * part.channels.size();
    std::vector<float> whole(static_cast<std::size_t>(rows.row_end - rows.row_begin) * row_values);
    read_tile_rows(rows, whole.data());
    std::copy_n(whole.data() + static_cast<std::size_t>(first_row - rows.row_begin) * row_values,
                static_cast<std::size_t>(row_count) * row_values, values);
  });
}

void BakedReader::read_tile_rows(const TileRows& rows, float* values) {
  if (chunks_->can_unpack(rows.part)) {
    const BakedPart& part = parts_[rows.part];
    const ExrLevel& level = chunks_->parts()[rows.part].levels[static_cast<std::size_t>(rows.level - part.first_level)];
    const auto columns = static_cast<std::size_t>(level.columns);
    const std::size_t first = level.first_chunk + static_cast<std::size_t>(rows.tile_first) * columns;
    for_each_item(rows.count() * level.columns, threads_,
                  [&](int tile) { unpack_tile(rows, first + static_cast<std::size_t>(tile), values); });
  } else {
    read_by_library(rows, values);
  }
  check_tile_rows(rows, values);
}

void BakedReader::unpack_tile(const TileRows& rows, std::size_t chunk, float* values) const {
  static thread_local std::vector<unsigned char> unpacked;
  chunks_->unpack(rows.part, chunk, unpacked);
  const ExrChunkArea area = chunks_->area(rows.part, chunk);
  const std::vector<BakedChannel>& wanted = parts_[rows.part].channels;
  const unsigned char* from = unpacked.data();
  for (int y = area.y; y < area.y + area.height; ++y)
    for (const ExrChannel& channel : chunks_->parts()[rows.part].channels) {
      const auto width = static_cast<std::size_t>(area.width);
      const auto found =
          std::find_if(wanted.begin(), wanted.end(), [&](const BakedChannel& one) { return one.name == channel.name; });
      if (found != wanted.end()) {
        float* to = values +
                    (texel_count(rows.width, y - rows.row_begin) + static_cast<std::size_t>(area.x)) * wanted.size() +
                    static_cast<std::size_t>(found - wanted.begin());
        put_row(from, channel.type == ExrChannel::kHalf, width, to, wanted.size());
      }
      from += width * static_cast<std::size_t>(channel.bytes());
    }
}

// Reads files whose compression only OpenEXR can unpack. Other programs may have written such files.
void BakedReader::read_by_library(const TileRows& rows, float* values) {
  use_exr_threads(threads_);
  const BakedPart& part = parts_[rows.part];
  Imf::TiledInputPart in(*file_, static_cast<int>(rows.part));
  const int l = rows.level - part.first_level;
  Imf::FrameBuffer buffer;
  for (std::size_t c = 0; c < part.channels.size(); ++c)
    buffer.insert(part.channels[c].name, row_slice(Imf::FLOAT, values + c, part.channels.size() * sizeof(float),
                                                   rows.width, rows.row_begin, rows.row_end - rows.row_begin));
  in.setFrameBuffer(buffer);
  for (int y = rows.tile_first; y <= rows.tile_last; ++y) try {
      in.readTiles(0, in.numXTiles(l) - 1, y, y, l);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(ErrorCode::kInput, fmt::format("{}: {}: cannot read a tile of part {}, level {}, tile row {}: {}. {}",
                                                 path_, kDamaged, part.name, rows.level, y, error.what(), kWriteAnew));
    }
}

void BakedReader::check_tile_rows(const TileRows& rows, const float* values) {
  if (row_checksums_ == nullptr) return;
  const std::size_t row_values = static_cast<std::size_t>(rows.width) * parts_[rows.part].channels.size();
  for (int tile_row = rows.tile_first; tile_row <= rows.tile_last; ++tile_row) {
    const int begin = tile_row * rows.tile_height, end = std::min(rows.row_end, begin + rows.tile_height);
    const std::size_t first = static_cast<std::size_t>(begin - rows.row_begin) * row_values;
    const std::size_t count = static_cast<std::size_t>(end - begin) * row_values;
    if (row_checksums_->is_same(rows.part, rows.level, tile_row, values + first, count)) continue;
    const std::string place = fmt::format("part {}, level {}, tile row {} (texel rows {} to {})",
                                          parts_[rows.part].name, rows.level, tile_row, begin, end - 1);
    if (check_ == TexelCheck::kRefuse)
      throw Error(ErrorCode::kInput,
                  fmt::format("{}: {}: {}: the checksum of the texels differs, so they have changed since the bake. {}",
                              path_, kDamaged, place, kWriteAnew));
    changed_rows_.push_back(place);
  }
}

// Checks the checksum of the whole file. Older files have no row checksums. Row checksums also do not apply if another
// program has rewritten the file with tiles of another size.
void BakedReader::check_content_hash() {
  is_content_checked_ = true;
  const std::string& stated = header_.provenance.content_hash;
  if (check_ == TexelCheck::kReport || stated.empty()) return;
  BakedRowHash hash(parts_);
  std::vector<float> values;
  for (std::size_t p = 0; p < parts_.size(); ++p)
    for (int l = parts_[p].first_level; l < parts_[p].first_level + parts_[p].level_count; ++l) {
      const int width = mip_level_size(header_.width, l), height = mip_level_size(header_.height, l);
      for (int row = 0; row < height; row += tile_size_) {
        const int count = std::min(tile_size_, height - row);
        values.resize(texel_count(width, count) * parts_[p].channels.size());
        read_values(p, l, row, count, values.data());
        hash.add(p, l, values.data(), values.size());
      }
    }
  const std::string found = hash.finish();
  if (found == stated) return;
  throw Error(ErrorCode::kInput,
              fmt::format("{}: {}: its texels have changed since the bake: found checksum {}, expected {} ({}). {}",
                          path_, kDamaged, found, stated, kContentHashAttribute, kWriteAnew));
}

BakedRowHash::BakedRowHash(const std::vector<BakedPart>& parts) {
  for (const BakedPart& part : parts) {
    first_levels_.push_back(part.first_level);
    hashes_.emplace_back(static_cast<std::size_t>(part.level_count));
  }
}

void BakedRowHash::add(std::size_t part, int level, const float* values, std::size_t value_count) {
  hashes_[part][static_cast<std::size_t>(level - first_levels_[part])].update(values, value_count * sizeof(float));
}

std::string BakedRowHash::finish() {
  ContentHash all;
  for (std::vector<ContentHash>& part : hashes_)
    for (ContentHash& level : part) all.update(level.finish());
  return all.finish();
}

}  // namespace multum
