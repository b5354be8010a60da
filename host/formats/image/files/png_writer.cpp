// SPDX-License-Identifier: Apache-2.0
// Writes PNG files with libpng, row by row.
#include "host/formats/image/files/png_writer.h"

#include <png.h>

#include <bit>
#include <csetjmp>
#include <cstdio>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_file.h"

namespace multum {
namespace {

struct PngFormat {
  int width, height, channels, bits;
  int compression_level;
  std::string colour_space;  // "sRGB", "Linear" or empty
};

int colour_type(int channels) {
  switch (channels) {
    case 1: return PNG_COLOR_TYPE_GRAY;
    case 3: return PNG_COLOR_TYPE_RGB;
    default: return PNG_COLOR_TYPE_RGB_ALPHA;
  }
}

// libpng's two objects for a file.
struct PngObjects {
  PngObjects(void* owner, png_error_ptr on_error) {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, owner, on_error, [](png_structp, png_const_charp) {});
    info = png != nullptr ? png_create_info_struct(png) : nullptr;
  }
  ~PngObjects() { png_destroy_write_struct(&png, &info); }
  PngObjects(const PngObjects&) = delete;
  PngObjects& operator=(const PngObjects&) = delete;

  png_structp png;
  png_infop info;
};

}  // namespace

class PngFile {
 public:
  PngFile(const std::string& path, PngFormat format)
      : file_(path), format_(std::move(format)), bytes_(file_), objects_(this, on_error) {
    if (objects_.info == nullptr) fail("libpng has no memory");
    guarded([this] { write_header(); });
  }

  /// Writes rows in the format that was given when the file was opened.
  void write_rows(int row_count, const void* interleaved) {
    MULTUM_CHECK(row_ + row_count <= format_.height);
    const auto row_bytes = static_cast<std::size_t>(format_.width * format_.channels * (format_.bits / 8));
    const auto* row = static_cast<const png_byte*>(interleaved);
    guarded([&] {
      for (int i = 0; i < row_count; ++i) png_write_row(objects_.png, row + static_cast<std::size_t>(i) * row_bytes);
    });
    row_ += row_count;
  }

  void finish() {
    MULTUM_CHECK(row_ == format_.height);
    guarded([this] { png_write_end(objects_.png, nullptr); });
    bytes_.close();
    file_.commit();
  }

 private:
  void write_header() {
    const png_structp png = objects_.png;
    const png_infop info = objects_.info;
    png_set_write_fn(png, this, on_write, [](png_structp) {});
    png_set_IHDR(png, info, static_cast<png_uint_32>(format_.width), static_cast<png_uint_32>(format_.height),
                 format_.bits, colour_type(format_.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, format_.compression_level);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_NO_FILTERS);  // same as OpenImageIO
    if (format_.colour_space == "sRGB") png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_ABSOLUTE);
    if (format_.colour_space == "Linear") png_set_gAMA(png, info, 1.0);
    png_write_info(png, info);
    if (format_.bits == 16 && std::endian::native == std::endian::little) png_set_swap(png);
  }

  // libpng reports failures by longjmp, so `work` must not hold objects with destructors.
  template <typename Work>
  void guarded(const Work& work) {
    if (setjmp(png_jmpbuf(objects_.png)) != 0) {
      if (!bytes_.failure().empty()) bytes_.close();  // throws the failure
      fail(message_);
    }
    work();
  }

  static void on_error(png_structp png, png_const_charp message) {
    auto* const self = static_cast<PngFile*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof(self->message_), "%s", message);
    png_longjmp(png, 1);
  }
  static void on_write(png_structp png, png_bytep bytes, png_size_t count) {
    auto* const self = static_cast<PngFile*>(png_get_io_ptr(png));
    if (!self->bytes_.write(bytes, count)) png_error(png, "");  // close() reports the reason
  }

  [[noreturn]] void fail(const char* what) const {
    throw Error(ErrorCode::kEnvironment, file_.path() + ": cannot be written: " + what);
  }

  AtomicFile file_;
  PngFormat format_;
  OutputFile bytes_;
  PngObjects objects_;
  char message_[128] = "";
  int row_ = 0;  // the next row
};

Png16Writer::Png16Writer(const std::string& path, int width, int height, const std::string& colour_space)
    : file_(std::make_unique<PngFile>(path, PngFormat{width, height, 3, 16, 1, colour_space})) {}

Png16Writer::~Png16Writer() = default;

void Png16Writer::write_rows(int row_count, const std::uint16_t* interleaved) {
  file_->write_rows(row_count, interleaved);
}

void Png16Writer::finish() { file_->finish(); }

Png8Writer::Png8Writer(const std::string& path, int width, int height, int channels)
    : file_(std::make_unique<PngFile>(path, PngFormat{width, height, channels, 8, 6, ""})) {}

Png8Writer::~Png8Writer() = default;

void Png8Writer::write_rows(int row_count, const std::uint8_t* interleaved) {
  file_->write_rows(row_count, interleaved);
}

void Png8Writer::finish() { file_->finish(); }

void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space) {
  MULTUM_CHECK(interleaved.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Png16Writer writer(path, width, height, colour_space);
  writer.write_rows(height, interleaved.data());
  writer.finish();
}

void write_png8(const std::string& path, const Png8Image& image) {
  MULTUM_CHECK(image.interleaved.size() == static_cast<std::size_t>(image.channels) *
                                               static_cast<std::size_t>(image.width) *
                                               static_cast<std::size_t>(image.height));
  PngFile file(path, {image.width, image.height, image.channels, 8, 6, "sRGB"});
  file.write_rows(image.height, image.interleaved.data());
  file.finish();
}

}  // namespace multum
