// SPDX-License-Identifier: Apache-2.0
// Opens the file only with the reader that its first bytes indicate. Before that,
// host/formats/image/files/image_container has checked the sizes. PNG and JPEG are read without their metadata.
#include "host/formats/decoder/libraries/oiio_image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/formats/decoder/file_ranges.h"
#include "host/formats/decoder/zlib_uncompress.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/exr_chunks.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

// The codes in host/formats/image/files/number_type.h must be the same as in OpenImageIO.
static_assert(number_type::kUint8 == OIIO::TypeDesc::UINT8 && number_type::kInt8 == OIIO::TypeDesc::INT8);
static_assert(number_type::kUint16 == OIIO::TypeDesc::UINT16 && number_type::kInt16 == OIIO::TypeDesc::INT16);
static_assert(number_type::kUint32 == OIIO::TypeDesc::UINT32 && number_type::kInt32 == OIIO::TypeDesc::INT32);
static_assert(number_type::kUint64 == OIIO::TypeDesc::UINT64 && number_type::kInt64 == OIIO::TypeDesc::INT64);
static_assert(number_type::kHalf == OIIO::TypeDesc::HALF && number_type::kFloat == OIIO::TypeDesc::FLOAT);
static_assert(number_type::kDouble == OIIO::TypeDesc::DOUBLE);

constexpr const char* kLuminanceChroma[] = {"Y", "RY", "BY"};

// Presents byte ranges of a file to OpenImageIO. The PNG reader of OpenImageIO 2.4 accepts this, but its JPEG reader
// accepts only files and memory.
class RangesProxy : public OIIO::Filesystem::IOProxy {
 public:
  RangesProxy(const std::string& path, const ImageContainer& container)
      : IOProxy(path, Read), ranges_(path, container.ranges, container.byte_words, container.patches) {}

  const char* proxytype() const override { return "file ranges"; }
  std::size_t read(void* data, std::size_t byte_count) override {
    const std::size_t got = pread(data, byte_count, m_pos);
    m_pos += static_cast<std::int64_t>(got);
    return got;
  }
  std::size_t pread(void* data, std::size_t byte_count, std::int64_t offset) override {
    return ranges_.read(data, byte_count, offset);
  }
  std::size_t size() const override { return static_cast<std::size_t>(ranges_.size()); }

 private:
  FileRanges ranges_;
};

struct OpenImage {
  std::vector<unsigned char> bytes;  // must outlive the reader, like `file`
  std::unique_ptr<OIIO::Filesystem::IOProxy> file;
  std::unique_ptr<OIIO::ImageInput> input;
};

// Presents the file without metadata. A JPEG file is held in memory, because its reader accepts no other source.
void leave_out_metadata(OpenImage& image, const std::string& path, const ImageContainer& container) {
  if (container.format == "jpeg") {
    image.bytes = FileRanges(path, container.ranges).read_all();
    image.file = std::make_unique<OIIO::Filesystem::IOMemReader>(image.bytes.data(), image.bytes.size());
  } else {
    image.file = std::make_unique<RangesProxy>(path, container);
  }
  image.input->set_ioproxy(image.file.get());
}

OpenImage open_image(const std::string& path, const ImageContainer& container) {
  OpenImage image;
  image.input = OIIO::ImageInput::create(container.format);
  if (!image.input)
    throw Error(ErrorCode::kEnvironment,
                path + ": this OpenImageIO cannot read " + container.format + ": " + OIIO::geterror());
  const bool is_changed = container.has_metadata || !container.byte_words.empty() || !container.patches.empty();
  if (is_changed && image.input->supports("ioproxy")) leave_out_metadata(image, path, container);
  OIIO::ImageSpec config;
  config.attribute("oiio:UnassociatedAlpha", 1);  // keeps PNG colour separate from alpha, which may hold a height
  OIIO::ImageSpec spec;
  if (!image.input->open(path, spec, config))
    refuse_file(path, fmt::format("damaged {}: {}", container.format, image.input->geterror()));
  return image;
}

// Workaround "PNG gamma": OpenImageIO 2.4.7 rounds the value of a gAMA chunk to two digits, for example to "Gamma1.9"
// for 1.85 (tests/cli/odd_inputs/odd_cases.py, albedos).
std::string colour_space_of(const OIIO::ImageSpec& spec, double gamma) {
  std::string name = spec.get_string_attribute("oiio:ColorSpace");
  return gamma > 0.0 && name.starts_with("Gamma") ? fmt::format("Gamma{:.9g}", gamma) : name;
}

ImagePart part_of(const OIIO::ImageSpec& spec, double gamma, bool with_texts) {
  ImagePart part;
  part.x = spec.x;
  part.y = spec.y;
  part.width = spec.width;
  part.height = spec.height;
  part.depth = spec.depth;
  part.full_x = spec.full_x;
  part.full_y = spec.full_y;
  part.full_width = spec.full_width;
  part.full_height = spec.full_height;
  part.tile_width = spec.tile_width;
  part.tile_height = spec.tile_height;
  part.alpha_channel = spec.alpha_channel;
  part.is_deep = spec.deep;
  part.base_type = spec.format.basetype;
  part.channel_names = spec.channelnames;
  // OpenImageIO 2.5 and later report red, green and blue for a luminance/chroma image. The reader rejects such images
  // by the names in the file.
  if (spec.get_int_attribute("openexr:luminancechroma", 0) != 0)
    for (std::size_t c = 0; c < std::min(part.channel_names.size(), std::size(kLuminanceChroma)); ++c)
      part.channel_names[c] = kLuminanceChroma[c];
  part.channel_names.resize(static_cast<std::size_t>(std::max(0, spec.nchannels)));
  for (const OIIO::TypeDesc& type : spec.channelformats) part.channel_types.push_back(type.basetype);
  part.colour_space = colour_space_of(spec, gamma);
  part.compression = spec.get_string_attribute("compression");
  part.rows_per_strip = spec.get_int_attribute("tiff:RowsPerStrip", 0);
  if (!with_texts) return part;
  for (const OIIO::ParamValue& attribute : spec.extra_attribs)
    if (attribute.type() == OIIO::TypeDesc::STRING)
      part.texts.try_emplace(attribute.name().string(), attribute.get_string());
  return part;
}

template <typename Number>
void invert_every(std::byte* memory, std::size_t count, std::size_t stride, Number white) {
  for (std::size_t i = 0; i < count; ++i) {
    Number value;
    std::byte* const at = memory + i * stride * sizeof(Number);
    std::memcpy(&value, at, sizeof(value));
    value = static_cast<Number>(white - value);
    std::memcpy(at, &value, sizeof(value));
  }
}

// Inverts grey, which is the first channel; alpha may follow.
void invert_first_channel(const ImagePart& part, const PixelBlock& block, std::byte* memory) {
  if (block.channel_begin > 0) return;
  const auto count = static_cast<std::size_t>(part.width) * static_cast<std::size_t>(block.y_end - block.y_begin);
  const auto stride = static_cast<std::size_t>(block.channel_end - block.channel_begin);
  switch (block.base_type) {
    case OIIO::TypeDesc::UINT8: return invert_every<std::uint8_t>(memory, count, stride, 0xFF);
    case OIIO::TypeDesc::UINT16: return invert_every<std::uint16_t>(memory, count, stride, 0xFFFF);
    case OIIO::TypeDesc::UINT32: return invert_every<std::uint32_t>(memory, count, stride, 0xFFFFFFFF);
    case OIIO::TypeDesc::FLOAT: return invert_every<float>(memory, count, stride, 1.0f);
    default: MULTUM_CHECK(false);
  }
}

class OiioImageFile : public LibraryImageFile {
 public:
  OiioImageFile(std::string path, const ImageContainer& container, const ImageFileSettings& settings)
      : path_(std::move(path)),
        threads_(settings.threads),
        exr_chunks_(container.format == "openexr" ? std::make_unique<ExrChunks>(path_) : nullptr),
        open_(open_image(path_, container)),
        inverts_integers_(container.inverts_integers) {
    description_ = {container.format, container.file_size,    {},
                    container.notes,  container.texel_metres, container.no_data};
    open_.input->threads(std::max(0, settings.threads));
    if (!settings.all_parts) {
      description_.parts.push_back(part_of(open_.input->spec(), container.gamma, false));
      return;
    }
    for (int part = 0; open_.input->seek_subimage(part, 0); ++part)
      description_.parts.push_back(part_of(open_.input->spec(), container.gamma, true));
    open_.input->geterror();  // clears the message about the end of the parts, which is not an error
  }

  std::string read_into(const PixelBlock& block, std::byte* memory) override {
    return with_damage_named(path_, [&] {
      if (exr_chunks_ != nullptr) check_exr_rows(block);
      return read_rows(block, memory);
    });
  }

 private:
  // Checks each row only once. Rows are mostly read once, from the top, so it suffices to store the number of the last
  // checked row.
  void check_exr_rows(const PixelBlock& block) {
    const auto index = static_cast<std::size_t>(block.part);
    if (index >= exr_chunks_->parts().size()) return;
    const ExrPart& part = exr_chunks_->parts()[index];
    exr_rows_checked_.resize(exr_chunks_->parts().size(), 0);
    int& checked = exr_rows_checked_[index];
    const int end = std::min(block.y_end - part.y, part.height);
    if (end > checked) exr_chunks_->check_rows(index, checked, end, threads_);
    // check_rows() also checks the rest of the last chunk.
    checked =
        std::max(checked, std::min(part.height, (end + part.chunk_height - 1) / part.chunk_height * part.chunk_height));
  }

  std::string read_rows(const PixelBlock& block, std::byte* memory) {
    const ImagePart& from = part(block.part);
    const OIIO::TypeDesc type(static_cast<OIIO::TypeDesc::BASETYPE>(block.base_type));
    const bool is_read =
        from.tile_width > 0
            ? open_.input->read_tiles(block.part, 0, from.x, from.x + from.width, block.y_begin, block.y_end, 0, 1,
                                      block.channel_begin, block.channel_end, type, memory)
            : open_.input->read_scanlines(block.part, 0, block.y_begin, block.y_end, 0, block.channel_begin,
                                          block.channel_end, type, memory);
    // The TIFF reader reports success for a truncated band. Only its message reveals the fault.
    const std::string message = open_.input->geterror();
    if (inverts_integers_) invert_first_channel(from, block, memory);
    return is_read || !message.empty() ? message : "the reader gives no reason";
  }

  std::string path_;
  int threads_;
  std::unique_ptr<ExrChunks> exr_chunks_;  // only for OpenEXR
  std::vector<int> exr_rows_checked_;      // index: [part]; number of checked rows, from the top
  OpenImage open_;
  bool inverts_integers_;  // as in ImageContainer
};

}  // namespace

std::unique_ptr<LibraryImageFile> open_library_image(const std::string& path, const ImageFileSettings& settings) {
  MULTUM_CHECK(replaces_zlib_uncompress());
  if (std::unique_ptr<LibraryImageFile> file = open_small_library_image(path, settings)) return file;
  return open_oiio_image(path, settings);
}

std::unique_ptr<LibraryImageFile> open_oiio_image(const std::string& path, const ImageFileSettings& settings) {
  const ImageContainer container = inspect_image_container(path, settings.texel_count_max);
  return with_damage_named(path, [&] { return std::make_unique<OiioImageFile>(path, container, settings); });
}

}  // namespace multum
