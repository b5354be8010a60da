// SPDX-License-Identifier: Apache-2.0
#include "host/asset/baked_reader.h"

#include <ImfTiledInputPart.h>

#include <algorithm>

#include "host/asset/exr/exr_rows.h"
#include "host/base/files/exr_survey.h"
#include "host/base/processes/machine.h"

namespace multum {
namespace {

int thread_count(int threads) { return threads > 0 ? threads : processor_count(); }

}  // namespace

BakedReader::BakedReader(const std::string& path, int threads) : path_(path), threads_(thread_count(threads)) {
  check_exr_headers(path, "not a readable baked file");
  guarded([&] {
    stream_ = std::make_unique<ExrInputStream>(path);
    file_ = std::make_unique<Imf::MultiPartInputFile>(*stream_, threads_);
  });
}

void BakedReader::expect(const BakedHeader& header, std::vector<BakedPart> parts) {
  check_baked_parts(*file_, header, parts, path_);
  header_ = header;
  parts_ = std::move(parts);
  tile_size_ = static_cast<int>(file_->header(0).tileDescription().ySize);
}

// OpenEXR gives whole rows of tiles: where those are more, they go by way of a buffer.
void BakedReader::read_values(std::size_t part_index, int level, int first_row, int row_count, float* values) {
  const BakedPart& part = parts_[part_index];
  const int width = mip_level_size(header_.width, level), height = mip_level_size(header_.height, level);
  MULTUM_CHECK(part.has_level(level) && first_row >= 0 && row_count >= 0 && first_row + row_count <= height);
  if (row_count == 0) return;
  use_exr_threads(threads_);
  guarded([&] {
    Imf::TiledInputPart in(*file_, static_cast<int>(part_index));
    const int tile = static_cast<int>(in.tileYSize()), l = level - part.first_level;
    const int tile_first = first_row / tile, tile_last = (first_row + row_count - 1) / tile;
    const int row_begin = tile_first * tile, row_end = std::min(height, (tile_last + 1) * tile);
    const bool exact = row_begin == first_row && row_end == first_row + row_count;
    const std::size_t row_values = static_cast<std::size_t>(width) * part.channels.size();
    std::vector<float> whole(exact ? 0 : static_cast<std::size_t>(row_end - row_begin) * row_values);
    const float* target = exact ? values : whole.data();
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < part.channels.size(); ++c)
      buffer.insert(part.channels[c].name, row_slice(Imf::FLOAT, target + c, part.channels.size() * sizeof(float),
                                                     width, row_begin, row_end - row_begin));
    in.setFrameBuffer(buffer);
    in.readTiles(0, in.numXTiles(l) - 1, tile_first, tile_last, l);
    if (!exact)
      std::copy_n(whole.data() + static_cast<std::size_t>(first_row - row_begin) * row_values,
                  static_cast<std::size_t>(row_count) * row_values, values);
  });
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
