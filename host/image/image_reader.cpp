// SPDX-License-Identifier: Apache-2.0
// One reader named by the file's first bytes is opened (never "try all of them"), after host/image/image_container has
// looked at the sizes; PNG and JPEG are read without their metadata. Rows come in bands, so that no image need fit into
// memory, a cut file costs its bands and cancelling is quick.
#include "host/image/image_reader.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <future>
#include <mutex>
#include <utility>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "host/base/error.h"
#include "host/image/damaged_file.h"
#include "host/image/file_ranges.h"
#include "host/image/image_container.h"

namespace multum {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& message) {
  throw Error(ErrorCode::kInput, path + ": " + message);
}

// The byte ranges of a file, joined: the file without its metadata.
std::vector<unsigned char> joined_ranges(const std::string& path, const std::vector<ByteRange>& ranges) {
  std::vector<unsigned char> bytes;
  std::ifstream stream(path, std::ios::binary);
  for (const ByteRange& range : ranges) {
    const std::size_t offset = bytes.size();
    bytes.resize(offset + static_cast<std::size_t>(range.end - range.begin));
    stream.seekg(range.begin);
    stream.read(reinterpret_cast<char*>(bytes.data() + offset), range.end - range.begin);
  }
  if (!stream) refuse(path, "cannot be read");
  return bytes;
}

SampleType sample_type_of(const std::string& path, const OIIO::ImageSpec& spec) {
  switch (spec.format.basetype) {
    case OIIO::TypeDesc::UINT8: return SampleType::kUint8;
    case OIIO::TypeDesc::UINT16: return SampleType::kUint16;
    case OIIO::TypeDesc::INT8:
    case OIIO::TypeDesc::INT16:
    case OIIO::TypeDesc::UINT32:
    case OIIO::TypeDesc::INT32: return SampleType::kOtherInteger;
    case OIIO::TypeDesc::HALF: return SampleType::kHalf;
    case OIIO::TypeDesc::FLOAT:
    case OIIO::TypeDesc::DOUBLE: return SampleType::kFloat;
    default: refuse(path, fmt::format("found samples of type {}, expected integers or floats", spec.format.c_str()));
  }
}

void check_flat(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.deep) refuse(path, "found a deep image, expected one value a texel");
  if (spec.depth > 1) refuse(path, fmt::format("found a volume of depth {}, expected a flat image", spec.depth));
}

// How many leading channels are colour: all but alpha, 1 to 3; or the first three of many when their names say so.
int colour_channel_count(const std::string& path, const OIIO::ImageSpec& spec) {
  const int without_alpha = spec.nchannels - (spec.alpha_channel >= 0 ? 1 : 0);
  const bool alpha_last = spec.alpha_channel < 0 || spec.alpha_channel == spec.nchannels - 1;
  if (without_alpha >= 1 && without_alpha <= 3 && alpha_last) return without_alpha;
  if (spec.channelnames.size() >= 3 && spec.nchannels >= 3 && spec.nchannels <= 64) {
    const std::string names = fmt::format("{}{}{}", spec.channelnames[0], spec.channelnames[1], spec.channelnames[2]);
    if (names == "RGB" || names == "XYZ") return 3;
  }
  refuse(path, fmt::format("found {} channels ({}...), expected 1 to 3 and an alpha", spec.nchannels,
                           spec.channelnames.empty() ? "unnamed" : spec.channelnames[0]));
}

// Deflate reaches 1032:1 at best and DWA codes blocks of 64 texels by one number that is then deflated: no picture is
// larger than that, so that a short file cannot ask for much memory. Small sizes are free.
void check_plausible_size(const std::string& path, const OIIO::ImageSpec& spec, std::int64_t file_size) {
  constexpr std::int64_t kExpansionMax = 1032 * 64;
  constexpr std::int64_t kFreeBytes = std::int64_t{64} << 20;
  const auto picture_bytes = static_cast<std::int64_t>(spec.image_bytes(true));
  if (picture_bytes < 0 || picture_bytes / kExpansionMax > file_size + kFreeBytes / kExpansionMax)
    refuse(path, fmt::format("declares {} x {} texels, which a file of {} bytes cannot hold", spec.width, spec.height,
                             file_size));
  constexpr std::int64_t kTileTexelsMax = 1 << 26;
  if (spec.tile_width > 0 && std::int64_t{spec.tile_width} * spec.tile_height > kTileTexelsMax)
    refuse(path,
           fmt::format("found tiles of {} x {}, expected at most 2^26 texels", spec.tile_width, spec.tile_height));
}

struct OpenImage {
  std::vector<unsigned char> bytes;  // both outlive the reader
  std::unique_ptr<OIIO::Filesystem::IOProxy> file;
  std::unique_ptr<OIIO::ImageInput> input;
};

// In memory for JPEG, whose reader takes no file of ours.
void leave_out_metadata(OpenImage& image, const std::string& path, const ImageContainer& container) {
  if (container.format == "jpeg") {
    image.bytes = joined_ranges(path, container.ranges);
    image.file = std::make_unique<OIIO::Filesystem::IOMemReader>(image.bytes.data(), image.bytes.size());
  } else {
    image.file = std::make_unique<FileRanges>(path, container.ranges);
  }
  image.input->set_ioproxy(image.file.get());
}

OpenImage open_image(const std::string& path, const ImageContainer& container) {
  OpenImage image;
  image.input = OIIO::ImageInput::create(container.format);
  if (!image.input)
    throw Error(ErrorCode::kEnvironment,
                path + ": this OpenImageIO cannot read " + container.format + ": " + OIIO::geterror());
  if (container.has_metadata && image.input->supports("ioproxy")) leave_out_metadata(image, path, container);
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // PNG alpha may hold a height; colour times height is no normal
  OIIO::ImageSpec spec;
  if (!image.input->open(path, spec, config))
    refuse(path, fmt::format("damaged {}: {}", container.format, image.input->geterror()));
  return image;
}

// Workaround "WebP alpha": OpenImageIO 2.4.7's WebP reader multiplies colour by alpha whatever it is asked for
// (ImageReaderTest.WebpWithAlphaIsRefused), and 8 bits cannot be divided back. Opaque alpha changes nothing.
void check_webp_opaque(const std::string& path, OIIO::ImageInput& input, const OIIO::ImageSpec& spec) {
  std::vector<float> row(static_cast<std::size_t>(spec.width));
  for (int y = spec.y; y < spec.y + spec.height; ++y) {
    if (!input.read_scanlines(0, 0, y, y + 1, spec.z, spec.alpha_channel, spec.alpha_channel + 1, OIIO::TypeDesc::FLOAT,
                              row.data()))
      refuse(path, fmt::format("damaged: row {} of {} cannot be read: {}", y, spec.height, input.geterror()));
    if (std::any_of(row.begin(), row.end(), [](float alpha) { return alpha < 1.0f; }))
      refuse(path, fmt::format("found a WebP whose alpha is not 1 (row {}), expected an opaque one: its colours come "
                               "multiplied by alpha; save it as PNG, or without alpha",
                               y));
  }
}

// What is stored of a sample: the file's own type, or floats where the channels' types differ.
OIIO::TypeDesc stored_type(const OIIO::ImageSpec& spec) {
  return spec.channelformats.empty() ? spec.format : OIIO::TypeDesc(OIIO::TypeDesc::FLOAT);
}

RawImageInfo image_info(const std::string& path, const OIIO::ImageSpec& spec, const std::string& container_format,
                        bool all_channels) {
  check_flat(path, spec);
  RawImageInfo info;
  info.width = spec.width;
  info.height = spec.height;
  info.sample_type = sample_type_of(path, spec);
  info.channel_count = all_channels ? spec.nchannels : colour_channel_count(path, spec);
  info.channel_names = spec.channelnames;
  info.channel_names.resize(static_cast<std::size_t>(info.channel_count));
  info.base_type = stored_type(spec).basetype;
  info.row_bytes = info.row_values() * stored_type(spec).size();
  info.colour_space = spec.get_string_attribute("oiio:ColorSpace");
  info.has_alpha = spec.alpha_channel >= 0;
  info.format = fmt::format("{} {}, {} channel{}{}", container_format, spec.format.c_str(), spec.nchannels,
                            spec.nchannels == 1 ? "" : "s", info.has_alpha && !all_channels ? " (alpha not read)" : "");
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height)
    info.format += fmt::format(", data window {} x {} of a {} x {} frame", spec.width, spec.height, spec.full_width,
                               spec.full_height);
  return info;
}

// Rows that a band must not cut through: of tiles, and of strips of doubles. Workaround "TIFF doubles": OpenImageIO
// 2.4.7's TIFF reader leaves 64-bit samples unread, without a word, unless whole strips of more than a row are asked
// for (ImageReaderTest.DoublesOfTiffAreRead). A single row that is left over is read with the band before it.
int whole_block_rows(const OIIO::ImageSpec& spec) {
  if (spec.tile_width > 0) return spec.tile_height;
  return spec.format == OIIO::TypeDesc::DOUBLE ? spec.get_int_attribute("tiff:RowsPerStrip", 1) : 1;
}

// Rows that are decoded together: a band that cuts through them may have them decoded twice.
int preferred_block_rows(const OIIO::ImageSpec& spec, const RawImageInfo& info) {
  constexpr std::size_t kStripBytesMax = std::size_t{4} << 20;
  const int whole = whole_block_rows(spec);
  if (whole > 1) return whole;
  const int strip_rows = spec.get_int_attribute("tiff:RowsPerStrip", 0);
  if (strip_rows > 0 && static_cast<std::size_t>(strip_rows) <= kStripBytesMax / info.row_bytes) return strip_rows;
  return spec.get_string_attribute("compression") == "dwab" ? 256 : 32;  // 32: OpenEXR's others
}

int band_rows(const OIIO::ImageSpec& spec, const RawImageInfo& info, int asked_rows) {
  constexpr std::size_t kBandBytes = std::size_t{2} << 20;
  constexpr std::size_t kRowsMin = 64, kRowsMax = 4096;  // at least: readers like to decode several blocks at once
  const std::size_t rows_of_size = std::clamp(kBandBytes / info.row_bytes, kRowsMin, kRowsMax);
  const int rows = asked_rows > 0 ? asked_rows : static_cast<int>(rows_of_size);
  const int block =
      std::clamp(asked_rows > 0 ? whole_block_rows(spec) : preferred_block_rows(spec, info), 1, info.height);
  return std::min(info.height, std::max(1, rows / block) * block);
}

}  // namespace

struct ImageReader::State {
  std::string path;
  OpenImage open;
  OIIO::ImageSpec spec;
  RawImageInfo info;
  int threads;
  int rows;  // of a band

  State(const std::string& image_path, const ImageReadSettings& settings);
  int band_end(int row_begin) const { return info.height - row_begin <= rows + 1 ? info.height : row_begin + rows; }
  void read_band(int row_begin, int row_end, std::byte* samples);
  void read(const std::function<void(const RawBand&)>& consume, Progress* progress);
};

ImageReader::State::State(const std::string& image_path, const ImageReadSettings& settings)
    : path(image_path), threads(settings.threads) {
  const ImageContainer container = inspect_image_container(path, settings.texel_count_max);
  open = open_image(path, container);
  spec = open.input->spec();
  check_image_size(path, spec.width, spec.height, settings.texel_count_max);
  info = image_info(path, spec, container.format, settings.all_channels);
  check_plausible_size(path, spec, container.file_size);
  if (container.format == "tiff" && spec.format == OIIO::TypeDesc::DOUBLE && spec.height == 1)
    refuse(path,
           "found one row of 64-bit floats, which OpenImageIO leaves unread; expected 32-bit floats, or more rows");
  rows = band_rows(spec, info, settings.band_rows);
  open.input->threads(std::max(0, settings.threads));
  if (container.format == "webp" && spec.alpha_channel >= 0) check_webp_opaque(path, *open.input, spec);
}

// Rows [row_begin, row_end) of the colour channels, interleaved.
void ImageReader::State::read_band(int row_begin, int row_end, std::byte* samples) {
  const int y_begin = spec.y + row_begin;
  const int y_end = spec.y + row_end;
  const OIIO::TypeDesc type = stored_type(spec);
  const bool is_read =
      spec.tile_width > 0
          ? open.input->read_tiles(0, 0, spec.x, spec.x + spec.width, y_begin, y_end, spec.z, spec.z + 1, 0,
                                   info.channel_count, type, samples)
          : open.input->read_scanlines(0, 0, y_begin, y_end, spec.z, 0, info.channel_count, type, samples);
  // The TIFF reader calls a band read that is cut; its message is the only sign.
  const std::string message = open.input->geterror();
  if (!is_read || !message.empty())
    refuse(path, fmt::format("damaged: rows {} to {} of {} cannot be read: {}", row_begin, row_end - 1, info.height,
                             message));
}

// Two bands: one is read while the other is consumed.
//   this thread    read 0 | read 1    | read 2    | ...
//   other thread          | consume 0 | consume 1 | ...
void ImageReader::State::read(const std::function<void(const RawBand&)>& consume, Progress* progress) {
  const auto launch = threads == 1 ? std::launch::deferred : std::launch::async;
  std::array<std::vector<std::byte>, 2> bands;
  for (std::vector<std::byte>& band : bands) band.resize(info.row_bytes * static_cast<std::size_t>(rows + 1));
  std::future<void> consumed;  // its destructor waits, while the bands are still there
  for (int row_begin = 0, band = 0; row_begin < info.height; row_begin = band_end(row_begin), band = 1 - band) {
    const int row_end = band_end(row_begin);
    std::byte* samples = bands[static_cast<std::size_t>(band)].data();
    read_band(row_begin, row_end, samples);
    if (consumed.valid()) consumed.get();
    const RawBand next{row_begin, row_end - row_begin, samples};
    consumed = std::async(launch, [&consume, next] { consume(next); });
    progress_advance(progress, 0);
  }
  consumed.get();
}

ImageReader::ImageReader(const std::string& path, const ImageReadSettings& settings) {
  static std::once_flag limits_once;
  std::call_once(limits_once, [] { OIIO::attribute("limits:channels", 64); });
  state_ = with_damage_named(path, [&] { return std::make_unique<State>(path, settings); });
}

ImageReader::~ImageReader() = default;

const RawImageInfo& ImageReader::info() const { return state_->info; }

void ImageReader::read(const std::function<void(const RawBand&)>& consume, Progress* progress) {
  with_damage_named(state_->path, [&] { state_->read(consume, progress); });
}

}  // namespace multum
