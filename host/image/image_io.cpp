// SPDX-License-Identifier: Apache-2.0
// One reader named by the file's first bytes is opened (never "try all of them"), after host/image/image_container has
// looked at the sizes; PNG and JPEG are read without their metadata. Rows come in bands, so
// that a cut file costs its bands and cancelling is quick.
#include "host/image/image_io.h"

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <new>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include "host/base/atomic_file.h"
#include "host/base/error.h"
#include "host/image/image_container.h"

namespace multum {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& message) {
  throw Error(ErrorCode::kInput, path + ": " + message);
}

// The byte ranges of a file, joined: the file without its metadata.
//   file    |signature IHDR|XMP ......|IDAT ........|text|IEND|
//   result  |signature IHDR|IDAT ........|IEND|
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

// How many leading channels are colour: all but alpha, 1 to 3; or the first three of many when their names say so.
int colour_channel_count(const std::string& path, const OIIO::ImageSpec& spec) {
  if (spec.deep) refuse(path, "found a deep image, expected one value a texel");
  if (spec.depth > 1) refuse(path, fmt::format("found a volume of depth {}, expected a flat image", spec.depth));
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
  std::unique_ptr<OIIO::Filesystem::IOMemReader> view;
  std::unique_ptr<OIIO::ImageInput> input;
};

OpenImage open_image(const std::string& path, const ImageContainer& container) {
  OpenImage image;
  image.input = OIIO::ImageInput::create(container.format);
  if (!image.input)
    throw Error(ErrorCode::kEnvironment,
                path + ": this OpenImageIO cannot read " + container.format + ": " + OIIO::geterror());
  if (container.has_metadata && image.input->supports("ioproxy")) {
    image.bytes = joined_ranges(path, container.ranges);  // in memory, since the JPEG reader takes no proxy of ours
    image.view = std::make_unique<OIIO::Filesystem::IOMemReader>(image.bytes.data(), image.bytes.size());
    image.input->set_ioproxy(image.view.get());
  }
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // PNG alpha may hold a height; colour times height is no normal
  OIIO::ImageSpec spec;
  if (!image.input->open(path, spec, config))
    refuse(path, fmt::format("damaged {}: {}", container.format, image.input->geterror()));
  return image;
}

// Rows [row_begin, row_end) of the colour channels, interleaved.
bool read_band(OIIO::ImageInput& input, const OIIO::ImageSpec& spec, int row_begin, int row_end, int channel_count,
               float* band) {
  const int y_begin = spec.y + row_begin;
  const int y_end = spec.y + row_end;
  if (spec.tile_width > 0)
    return input.read_tiles(0, 0, spec.x, spec.x + spec.width, y_begin, y_end, spec.z, spec.z + 1, 0, channel_count,
                            OIIO::TypeDesc::FLOAT, band);
  return input.read_scanlines(0, 0, y_begin, y_end, spec.z, 0, channel_count, OIIO::TypeDesc::FLOAT, band);
}

// Workaround "WebP alpha": OpenImageIO 2.4.7's WebP reader multiplies colour by alpha whatever it is asked for
// (ImageIo.WebpWithAlphaIsRefused), and 8 bits cannot be divided back. Opaque alpha changes nothing.
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

void read_planes(const std::string& path, OIIO::ImageInput& input, const OIIO::ImageSpec& spec, RawImage& image,
                 Progress* progress) {
  const auto channel_count = image.planes.size();
  const auto width = static_cast<std::size_t>(image.width);
  // About 4 Mi floats a band, whole tiles, at least the 64 rows that a reader likes to decode at once.
  int rows = static_cast<int>(std::clamp<std::size_t>((std::size_t{1} << 22) / (width * channel_count), 64, 4096));
  if (spec.tile_height > 0) rows = std::max(1, rows / spec.tile_height) * spec.tile_height;
  rows = std::min(rows, image.height);
  std::vector<float> band(static_cast<std::size_t>(rows) * width * channel_count);
  for (int row_begin = 0; row_begin < image.height; row_begin += rows) {
    const int row_end = std::min(image.height, row_begin + rows);
    // The TIFF reader calls a band read that is cut; its message is the only sign.
    const bool is_read = read_band(input, spec, row_begin, row_end, static_cast<int>(channel_count), band.data());
    const std::string message = input.geterror();
    if (!is_read || !message.empty())
      refuse(path, fmt::format("damaged: rows {} to {} of {} cannot be read: {}", row_begin, row_end - 1, image.height,
                               message));
    const std::size_t texel_count = static_cast<std::size_t>(row_end - row_begin) * width;
    const std::size_t offset = static_cast<std::size_t>(row_begin) * width;
    for (std::size_t c = 0; c < channel_count; ++c)
      for (std::size_t i = 0; i < texel_count; ++i) image.planes[c][offset + i] = band[i * channel_count + c];
    progress_advance(progress, 0);
  }
}

RawImage read_checked(const std::string& path, const ImageReadSettings& settings, Progress* progress) {
  const ImageContainer container = inspect_image_container(path, settings.texel_count_max);
  const OpenImage open = open_image(path, container);
  const OIIO::ImageSpec spec = open.input->spec();
  check_image_size(path, spec.width, spec.height, settings.texel_count_max);
  RawImage image;
  image.sample_type = sample_type_of(path, spec);
  const int channel_count = colour_channel_count(path, spec);
  check_plausible_size(path, spec, container.file_size);
  image.width = spec.width;
  image.height = spec.height;
  image.colour_space = spec.get_string_attribute("oiio:ColorSpace");
  image.has_alpha = spec.alpha_channel >= 0;
  image.format = fmt::format("{} {}, {} channel{}{}", container.format, spec.format.c_str(), spec.nchannels,
                             spec.nchannels == 1 ? "" : "s", image.has_alpha ? " (alpha not read)" : "");
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height)
    image.format += fmt::format(", data window {} x {} of a {} x {} frame", spec.width, spec.height, spec.full_width,
                                spec.full_height);
  open.input->threads(std::max(0, settings.threads));
  const auto texel_count = static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height);
  image.planes.assign(static_cast<std::size_t>(channel_count), std::vector<float>(texel_count));
  if (container.format == "webp" && spec.alpha_channel >= 0) check_webp_opaque(path, *open.input, spec);
  read_planes(path, *open.input, spec, image, progress);
  return image;
}

}  // namespace

RawImage read_raw_image(const std::string& path, const ImageReadSettings& settings, Progress* progress) {
  static std::once_flag limits_once;
  std::call_once(limits_once, [] { OIIO::attribute("limits:channels", 64); });
  try {
    return read_checked(path, settings, progress);
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kEnvironment, path + ": not enough memory to read it");
  } catch (const Error&) {
    throw;
  } catch (const std::runtime_error& error) {  // OpenEXR's own exceptions may pass through OpenImageIO
    refuse(path, std::string("damaged: ") + error.what());
  } catch (const std::logic_error& error) {
    refuse(path, std::string("damaged: ") + error.what());
  }
}

void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space) {
  MULTUM_CHECK(interleaved.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  AtomicFile file(path);
  const auto output = OIIO::ImageOutput::create("png");
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT16);
  spec.attribute("png:compressionLevel", 1);  // much faster than the default
  spec.attribute("oiio:ColorSpace", colour_space);
  if (!output || !output->open(file.temporary_path(), spec) ||
      !output->write_image(OIIO::TypeDesc::UINT16, interleaved.data()) || !output->close())
    throw Error(ErrorCode::kEnvironment,
                path + ": cannot be written: " + (output ? output->geterror() : OIIO::geterror()));
  file.commit();
}

}  // namespace multum
