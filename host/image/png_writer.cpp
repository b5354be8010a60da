// SPDX-License-Identifier: Apache-2.0
// libpng, one row after another.
#include "host/image/png_writer.h"

#include <png.h>

#include <bit>
#include <cerrno>
#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <utility>

#include "host/base/atomic_file.h"
#include "host/base/error.h"

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
    case 2: return PNG_COLOR_TYPE_GRAY_ALPHA;
    case 3: return PNG_COLOR_TYPE_RGB;
    default: return PNG_COLOR_TYPE_RGB_ALPHA;
  }
}

}  // namespace

class PngFile {
 public:
  PngFile(const std::string& path, PngFormat format)
      : file_(path), format_(std::move(format)), stream_(std::fopen(file_.temporary_path().c_str(), "wb")) {
    if (stream_ == nullptr) fail(std::strerror(errno));
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    if (info_ == nullptr) {
      release();
      fail("no memory");
    }
    guarded([this] { write_header(); });
  }
  ~PngFile() { release(); }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  /// In the format that the file was opened with.
  void write_rows(int row_count, const void* interleaved) {
    MULTUM_CHECK(row_ + row_count <= format_.height);
    const auto row_bytes = static_cast<std::size_t>(format_.width * format_.channels * (format_.bits / 8));
    const auto* row = static_cast<const png_byte*>(interleaved);
    guarded([&] {
      for (int i = 0; i < row_count; ++i) png_write_row(png_, row + static_cast<std::size_t>(i) * row_bytes);
    });
    row_ += row_count;
  }

  void finish() {
    MULTUM_CHECK(row_ == format_.height);
    guarded([this] { png_write_end(png_, nullptr); });
    std::FILE* const stream = std::exchange(stream_, nullptr);
    if (std::fclose(stream) != 0) fail(std::strerror(errno));
    file_.commit();
  }

 private:
  void write_header() {
    png_init_io(png_, stream_);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(format_.width), static_cast<png_uint_32>(format_.height),
                 format_.bits, colour_type(format_.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png_, format_.compression_level);
    png_set_filter(png_, PNG_FILTER_TYPE_BASE, PNG_NO_FILTERS);  // noise gets no smaller by filters, only slower
    if (format_.colour_space == "sRGB") png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_ABSOLUTE);
    if (format_.colour_space == "Linear") png_set_gAMA(png_, info_, 1.0);
    png_write_info(png_, info_);
    if (format_.bits == 16 && std::endian::native == std::endian::little) png_set_swap(png_);
  }

  // libpng ends by longjmp where it fails: `work` holds nothing that has a destructor.
  template <typename Work>
  void guarded(const Work& work) {
    if (setjmp(png_jmpbuf(png_)) != 0) fail(message_);
    work();
  }

  static void on_error(png_structp png, png_const_charp message) {
    auto* const self = static_cast<PngFile*>(png_get_error_ptr(png));
    std::snprintf(self->message_, sizeof(self->message_), "%s", message);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}

  void release() {
    if (png_ != nullptr) png_destroy_write_struct(&png_, &info_);
    if (stream_ != nullptr) std::fclose(std::exchange(stream_, nullptr));
  }

  [[noreturn]] void fail(const char* what) const {
    throw Error(ErrorCode::kEnvironment, file_.path() + ": cannot be written: " + what);
  }

  AtomicFile file_;
  PngFormat format_;
  std::FILE* stream_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char message_[128] = "";
  int row_ = 0;  // the next
};

Png16Writer::Png16Writer(const std::string& path, int width, int height, const std::string& colour_space)
    : file_(std::make_unique<PngFile>(path, PngFormat{width, height, 3, 16, 1, colour_space})) {}

Png16Writer::~Png16Writer() = default;

void Png16Writer::write_rows(int row_count, const std::uint16_t* interleaved) {
  file_->write_rows(row_count, interleaved);
}

void Png16Writer::finish() { file_->finish(); }

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
