// SPDX-License-Identifier: Apache-2.0
// Reads rows in bands. Therefore images can be larger than memory, a truncated file costs only the time for the bands
// that it has, and cancelling is quick.
#include "host/formats/image/image_reader.h"

#include <algorithm>
#include <future>

#include <fmt/format.h>

#include "host/formats/image/files/image_file.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

SampleType sample_type_of(const std::string& path, const ImagePart& part) {
  switch (part.base_type) {
    case number_type::kUint8: return SampleType::kUint8;
    case number_type::kUint16: return SampleType::kUint16;
    case number_type::kInt8:
    case number_type::kInt16:
    case number_type::kUint32:
    case number_type::kInt32: return SampleType::kOtherInteger;
    case number_type::kHalf: return SampleType::kHalf;
    case number_type::kFloat:
    case number_type::kDouble: return SampleType::kFloat;
    default:
      refuse_file(path,
                  fmt::format("found samples of type {}, expected integers or floats", number_name(part.base_type)));
  }
}

void check_flat(const std::string& path, const ImagePart& part) {
  if (part.is_deep) refuse_file(path, "found a deep image, expected one value per texel");
  if (part.depth > 1) refuse_file(path, fmt::format("found a volume of depth {}, expected a flat image", part.depth));
}

// Rejects luminance/chroma images, which OpenEXR's own programs can write, because they do not hold vectors or RGB.
void check_no_luminance(const std::string& path, const ImagePart& part) {
  for (const std::string& name : part.channel_names)
    if (const std::string last = name.substr(name.rfind('.') + 1); last == "RY" || last == "BY")
      refuse_file(
          path,
          fmt::format("found channel {} of a luminance/chroma image (Y, RY, BY), expected red, green and blue", name));
}

constexpr int kColourChannelCountMax = 64;

// Returns the number of leading colour channels. If there are 1 to 3 channels except alpha, all of these are colour
// channels. If there are more, the first three are, provided that they are named RGB or XYZ.
int colour_channel_count(const std::string& path, const ImagePart& part) {
  const int without_alpha = part.channel_count() - (part.alpha_channel >= 0 ? 1 : 0);
  const bool alpha_last = part.alpha_channel < 0 || part.alpha_channel == part.channel_count() - 1;
  if (without_alpha >= 1 && without_alpha <= 3 && alpha_last) return without_alpha;
  if (part.channel_count() >= 3 && part.channel_count() <= kColourChannelCountMax) {
    const std::string names =
        fmt::format("{}{}{}", part.channel_names[0], part.channel_names[1], part.channel_names[2]);
    if (names == "RGB" || names == "XYZ") return 3;
  }
  refuse_file(path, fmt::format("found {} channels ({}...), expected 1 to 3 and an optional alpha",
                                part.channel_count(), part.channel_names[0]));
}

// Rejects sizes that the file cannot hold, so that a short file cannot demand much memory. Deflate compresses by at
// most 1032:1, and DWA encodes blocks of 64 texels as one number, which is then deflated. Small sizes are always
// accepted.
void check_plausible_size(const std::string& path, const ImagePart& part, std::int64_t file_size) {
  constexpr std::int64_t kExpansionMax = 1032 * 64;
  constexpr std::int64_t kFreeBytes = std::int64_t{64} << 20;
  const auto picture_bytes = std::int64_t{part.width} * part.height * static_cast<std::int64_t>(part.texel_bytes());
  if (picture_bytes / kExpansionMax > file_size + kFreeBytes / kExpansionMax)
    refuse_file(path, fmt::format("declares {} x {} texels, more than a file of {} bytes can hold", part.width,
                                  part.height, file_size));
  constexpr std::int64_t kTileTexelsMax = 1 << 26;
  if (part.tile_width > 0 && std::int64_t{part.tile_width} * part.tile_height > kTileTexelsMax)
    refuse_file(path,
                fmt::format("found tiles of {} x {}, expected at most 2^26 texels", part.tile_width, part.tile_height));
}

// Workaround "WebP alpha": OpenImageIO 2.4.7's WebP reader always multiplies colour by alpha
// (ImageReaderTest.WebpWithAlphaIsRefused), and 8-bit values cannot be divided by alpha again. Opaque alpha changes
// nothing.
void check_webp_opaque(const std::string& path, ImageFile& file) {
  constexpr int kRows = 64;
  const ImagePart& part = file.part();
  const auto width = static_cast<std::size_t>(part.width);
  std::byte* const memory = file.reserve(width * kRows);
  for (int y = part.y; y < part.y + part.height; y += kRows) {
    const int y_end = std::min(y + kRows, part.y + part.height);
    const std::string message =
        file.read({0, y, y_end, part.alpha_channel, part.alpha_channel + 1, number_type::kUint8}, 0);
    if (!message.empty())
      refuse_file(path, fmt::format("damaged: cannot read rows from {} of {}: {}", y, part.height, message));
    const std::byte* const end = memory + width * static_cast<std::size_t>(y_end - y);
    const std::byte* const clear =
        std::find_if<const std::byte*>(memory, end, [](std::byte alpha) { return alpha < std::byte{255}; });
    if (clear != end)
      refuse_file(path, fmt::format("found a WebP whose alpha is not 1 (row {}), expected opaque texels, because its "
                                    "colours are multiplied by alpha; save it as PNG, or without alpha",
                                    y + static_cast<int>(static_cast<std::size_t>(clear - memory) / width)));
  }
}

// Returns the type for samples in memory. It is the file's own type, or float if the channels have different types.
int stored_type(const ImagePart& part) { return part.channel_types.empty() ? part.base_type : number_type::kFloat; }

RawImageInfo image_info(const std::string& path, const ImagePart& part, const std::string& container_format,
                        bool all_channels) {
  check_flat(path, part);
  if (container_format == "openexr") check_no_luminance(path, part);
  if (part.channel_count() > kColourChannelCountMax)
    refuse_file(path,
                fmt::format("found {} channels, expected at most {}", part.channel_count(), kColourChannelCountMax));
  RawImageInfo info;
  info.width = part.width;
  info.height = part.height;
  info.sample_type = sample_type_of(path, part);
  info.channel_count = all_channels ? part.channel_count() : colour_channel_count(path, part);
  info.channel_names = part.channel_names;
  info.channel_names.resize(static_cast<std::size_t>(info.channel_count));
  info.base_type = stored_type(part);
  info.row_bytes = info.row_values() * number_bytes(info.base_type);
  info.colour_space = part.colour_space;
  info.has_alpha = part.alpha_channel >= 0;
  info.format =
      fmt::format("{} {}, {} channel{}{}", container_format, number_name(part.base_type), part.channel_count(),
                  part.channel_count() == 1 ? "" : "s", info.has_alpha && !all_channels ? " (alpha not read)" : "");
  if (part.x != part.full_x || part.y != part.full_y || part.width != part.full_width ||
      part.height != part.full_height)
    info.format += fmt::format(", data window {} x {} of a {} x {} frame", part.width, part.height, part.full_width,
                               part.full_height);
  return info;
}

// Returns the number of rows that bands must not separate: a row of tiles, or a strip of doubles. Workaround "TIFF
// doubles": the TIFF reader of OpenImageIO 2.4.7 silently leaves 64-bit samples unread, unless it is asked for whole
// strips of more than one row (ImageReaderTest.DoublesOfTiffAreRead). A single last row is read with the band before
// it.
int whole_block_rows(const ImagePart& part) {
  if (part.tile_width > 0) return part.tile_height;
  return part.base_type == number_type::kDouble ? std::max(1, part.rows_per_strip) : 1;
}

// Returns the number of rows that are decoded together. If a band splits these rows, they may be decoded twice.
int preferred_block_rows(const ImagePart& part, const RawImageInfo& info) {
  constexpr std::size_t kStripBytesMax = std::size_t{4} << 20;
  const int whole = whole_block_rows(part);
  if (whole > 1) return whole;
  const int strip_rows = part.rows_per_strip;
  if (strip_rows > 0 && static_cast<std::size_t>(strip_rows) <= kStripBytesMax / info.row_bytes) return strip_rows;
  return part.compression == "dwab" ? 256 : 32;  // OpenEXR's other compressions have at most 32
}

int band_rows(const ImagePart& part, const RawImageInfo& info, int asked_rows) {
  constexpr std::size_t kBandBytes = std::size_t{2} << 20;
  constexpr std::size_t kRowsMin = 64, kRowsMax = 4096;  // at least 64, because readers prefer to decode several blocks
                                                         // at once
  const std::size_t rows_of_size = std::clamp(kBandBytes / info.row_bytes, kRowsMin, kRowsMax);
  const int rows = asked_rows > 0 ? asked_rows : static_cast<int>(rows_of_size);
  const int block =
      std::clamp(asked_rows > 0 ? whole_block_rows(part) : preferred_block_rows(part, info), 1, info.height);
  return std::min(info.height, std::max(1, rows / block) * block);
}

}  // namespace

struct ImageReader::State {
  std::string path;
  std::unique_ptr<ImageFile> file;
  RawImageInfo info;
  int threads;
  int rows;  // rows of a band

  State(const std::string& image_path, const ImageReadSettings& settings);
  int band_end(int row_begin) const { return info.height - row_begin <= rows + 1 ? info.height : row_begin + rows; }
  void read_band(int row_begin, int row_end, std::size_t offset, Progress* progress);
  void read(const std::function<void(const RawBand&)>& consume, Progress* progress);
};

ImageReader::State::State(const std::string& image_path, const ImageReadSettings& settings)
    : path(image_path),
      file(open_image_file(path, {settings.texel_count_max, settings.threads})),
      threads(settings.threads) {
  const ImagePart& part = file->part();
  const std::string& format = file->description().format;
  info = image_info(path, part, format, settings.all_channels);
  info.notes = file->description().notes;
  info.texel_metres = file->description().texel_metres;
  info.no_data = file->description().no_data;
  check_plausible_size(path, part, file->description().file_size);
  if (format == "tiff" && part.base_type == number_type::kDouble && part.height == 1)
    refuse_file(
        path, "found one row of 64-bit floats, which OpenImageIO does not read; expected 32-bit floats, or more rows");
  rows = band_rows(part, info, settings.band_rows);
  if (format == "webp" && part.alpha_channel >= 0) check_webp_opaque(path, *file);
}

// Reads rows [row_begin, row_end) of the colour channels, interleaved, to the file's memory.
void ImageReader::State::read_band(int row_begin, int row_end, std::size_t offset, Progress* progress) {
  const int y = file->part().y;
  const std::string message = file->read({0, y + row_begin, y + row_end, 0, info.channel_count, info.base_type}, offset,
                                         [&] { progress_advance(progress, 0); });
  if (!message.empty())
    refuse_file(path, fmt::format("damaged: cannot read rows {} to {} of {}: {}", row_begin, row_end - 1, info.height,
                                  message));
}

// Uses two bands. One is read while the other is consumed.
//   this thread    read 0 | read 1    | read 2    | ...
//   other thread          | consume 0 | consume 1 | ...
void ImageReader::State::read(const std::function<void(const RawBand&)>& consume, Progress* progress) {
  const auto launch = threads == 1 ? std::launch::deferred : std::launch::async;
  const std::size_t band_bytes = info.row_bytes * static_cast<std::size_t>(rows + 1);
  std::byte* const memory = file->reserve(2 * band_bytes);
  std::future<void> consumed;  // its destructor waits for the other thread while the bands still exist
  std::size_t offset = 0;
  for (int row_begin = 0; row_begin < info.height; row_begin = band_end(row_begin), offset = band_bytes - offset) {
    const int row_end = band_end(row_begin);
    read_band(row_begin, row_end, offset, progress);
    if (consumed.valid()) consumed.get();
    const RawBand next{row_begin, row_end - row_begin, memory + offset};
    consumed = std::async(launch, with_own_log([&consume, next] { consume(next); }));
    progress_advance(progress, 0);
  }
  consumed.get();
}

ImageReader::ImageReader(const std::string& path, const ImageReadSettings& settings) {
  state_ = with_damage_named(path, [&] { return std::make_unique<State>(path, settings); });
}

ImageReader::~ImageReader() = default;

const RawImageInfo& ImageReader::info() const { return state_->info; }

void ImageReader::read(const std::function<void(const RawBand&)>& consume, Progress* progress) {
  with_damage_named(state_->path, [&] { state_->read(consume, progress); });
}

}  // namespace multum
