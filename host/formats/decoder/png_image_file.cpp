// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/png_image_file.h"

#include <fmt/format.h>
#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <vector>

#include "host/formats/decoder/file_ranges.h"
#include "host/formats/decoder/row_image_file.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

class PngStream : public RowStream {
 public:
  PngStream(const std::string& path, const ImageContainer& container)
      : gamma_(container.gamma), file_(path, container.ranges) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, [](png_structp, png_const_charp) {});
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    const std::string message = info_ != nullptr ? guarded([this] { read_header(); }) : "";
    if (info_ != nullptr && message.empty()) return;
    png_destroy_read_struct(&png_, &info_, nullptr);
    if (message.empty()) throw NotEnoughMemory(path);
    refuse_file(path, "damaged png: " + message);
  }
  ~PngStream() override { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngStream(const PngStream&) = delete;
  PngStream& operator=(const PngStream&) = delete;

  ImagePart part() const override {
    ImagePart part;
    part.width = part.full_width = static_cast<int>(png_get_image_width(png_, info_));
    part.height = part.full_height = static_cast<int>(png_get_image_height(png_, info_));
    part.base_type = png_get_bit_depth(png_, info_) == 16 ? number_type::kUint16 : number_type::kUint8;
    const int channels = png_get_channels(png_, info_);
    part.channel_names = channels <= 2 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
    if (channels % 2 == 0) {
      part.channel_names.emplace_back("A");
      part.alpha_channel = channels - 1;
    }
    part.colour_space = gamma_ == 0.0 ? "sRGB" : gamma_ == 1.0 ? "linear" : fmt::format("Gamma{:.9g}", gamma_);
    return part;
  }

  std::string read_row(std::uint8_t* row) override {
    if (png_get_interlace_type(png_, info_) == PNG_INTERLACE_NONE)
      return guarded([&] { png_read_row(png_, row, nullptr); });
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    std::string message;
    if (all_rows_.empty()) message = read_interlaced(row_bytes);
    std::memcpy(row, all_rows_.data() + next_row_++ * row_bytes, row_bytes);
    return message;
  }

 private:
  void read_header() {
    png_set_read_fn(png_, this, on_read);
    png_read_info(png_, info_);
    const int colour_type = png_get_color_type(png_, info_), bits = png_get_bit_depth(png_, info_);
    if (colour_type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (colour_type == PNG_COLOR_TYPE_GRAY && bits < 8) png_set_expand_gray_1_2_4_to_8(png_);
    if (png_get_valid(png_, info_, PNG_INFO_tRNS) != 0) png_set_tRNS_to_alpha(png_);
    if (bits == 16 && std::endian::native == std::endian::little) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
  }

  // An interlaced file stores no row before the last of its passes.
  std::string read_interlaced(std::size_t row_bytes) {
    const std::size_t height = png_get_image_height(png_, info_);
    all_rows_.resize(height * row_bytes);
    std::vector<png_bytep> rows;
    for (std::size_t y = 0; y < height; ++y) rows.push_back(all_rows_.data() + y * row_bytes);
    return guarded([&] { png_read_image(png_, rows.data()); });
  }

  // libpng reports failures by longjmp, so `work` must not hold objects with destructors.
  template <typename Work>
  std::string guarded(const Work& work) {
    message_[0] = '\0';
    if (setjmp(png_jmpbuf(png_)) == 0) work();
    return message_;
  }

  static void on_error(png_structp png, png_const_charp message) {
    auto* const self = static_cast<PngStream*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof(self->message_), "%s", message[0] != '\0' ? message : "unknown error");
    png_longjmp(png, 1);
  }
  static void on_read(png_structp png, png_bytep bytes, png_size_t count) {
    auto* const self = static_cast<PngStream*>(png_get_io_ptr(png));
    const std::size_t got = self->file_.read(bytes, count, self->position_);
    self->position_ += static_cast<std::int64_t>(got);
    if (got < count) png_error(png, "the file ends early");
  }

  double gamma_;  // as in ImageContainer
  FileRanges file_;
  std::int64_t position_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char message_[128] = "";
  std::vector<png_byte> all_rows_;  // of an interlaced file
  std::size_t next_row_ = 0;
};

}  // namespace

std::unique_ptr<LibraryImageFile> open_png_image(const std::string& path, const ImageContainer& container) {
  const auto open = [=] { return std::make_unique<PngStream>(path, container); };
  return make_row_image_file(container, open(), open);
}

}  // namespace multum
