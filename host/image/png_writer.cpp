// SPDX-License-Identifier: Apache-2.0
#include "host/image/png_writer.h"

#include <OpenImageIO/imageio.h>

#include "host/base/atomic_file.h"
#include "host/base/error.h"

namespace multum {

class PngFile {
 public:
  PngFile(const std::string& path, const OIIO::ImageSpec& spec)
      : file_(path), output_(OIIO::ImageOutput::create("png")) {
    if (!output_ || !output_->open(file_.temporary_path(), spec)) fail();
  }

  /// In the format that the file was opened with.
  void write_rows(int row_count, const void* interleaved) {
    const int row_end = row_ + row_count;
    MULTUM_CHECK(row_end <= output_->spec().height);
    if (!output_->write_scanlines(row_, row_end, 0, output_->spec().format, interleaved)) fail();
    row_ = row_end;
  }

  void finish() {
    MULTUM_CHECK(row_ == output_->spec().height);
    if (!output_->close()) fail();
    file_.commit();
  }

 private:
  [[noreturn]] void fail() const {
    throw Error(ErrorCode::kEnvironment,
                file_.path() + ": cannot be written: " + (output_ ? output_->geterror() : OIIO::geterror()));
  }

  AtomicFile file_;
  std::unique_ptr<OIIO::ImageOutput> output_;  // closes before the file goes
  int row_ = 0;                                // the next
};

namespace {

OIIO::ImageSpec map_spec(int width, int height, const std::string& colour_space) {
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT16);
  spec.attribute("png:compressionLevel", 1);  // much faster than the default
  spec.attribute("oiio:ColorSpace", colour_space);
  return spec;
}

}  // namespace

Png16Writer::Png16Writer(const std::string& path, int width, int height, const std::string& colour_space)
    : file_(std::make_unique<PngFile>(path, map_spec(width, height, colour_space))) {}

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
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  spec.attribute("oiio:UnassociatedAlpha", 1);  // or the writer divides by alpha
  PngFile file(path, spec);
  file.write_rows(image.height, image.interleaved.data());
  file.finish();
}

}  // namespace multum
