// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/jpeg_image_file.h"

#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <utility>
#include <vector>

#include <jpeglib.h>

#include "host/formats/decoder/file_ranges.h"
#include "host/formats/decoder/row_image_file.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/sandbox/damaged_file.h"

namespace multum {
namespace {

class JpegStream : public RowStream {
 public:
  JpegStream(const std::string& path, const ImageContainer& container)
      : bytes_(FileRanges(path, container.ranges).read_all()) {
    jpeg_.err = jpeg_std_error(&errors_);
    errors_.error_exit = on_error;
    errors_.output_message = [](j_common_ptr) {};
    errors_.emit_message = on_message;
    jpeg_.client_data = this;
    jpeg_create_decompress(&jpeg_);
    const std::string message = guarded([this] {
      jpeg_mem_src(&jpeg_, bytes_.data(), bytes_.size());
      jpeg_read_header(&jpeg_, TRUE);
      if (is_supported()) jpeg_start_decompress(&jpeg_);
    });
    if (message.empty()) return;
    jpeg_destroy_decompress(&jpeg_);
    refuse_file(path, "damaged jpeg: " + message);
  }
  ~JpegStream() override { jpeg_destroy_decompress(&jpeg_); }
  JpegStream(const JpegStream&) = delete;
  JpegStream& operator=(const JpegStream&) = delete;

  bool is_supported() const { return jpeg_.out_color_space == JCS_GRAYSCALE || jpeg_.out_color_space == JCS_RGB; }

  ImagePart part() const override {
    ImagePart part;
    part.width = part.full_width = static_cast<int>(jpeg_.output_width);
    part.height = part.full_height = static_cast<int>(jpeg_.output_height);
    part.base_type = number_type::kUint8;
    part.channel_names =
        jpeg_.output_components == 1 ? std::vector<std::string>{"Y"} : std::vector<std::string>{"R", "G", "B"};
    part.colour_space = "sRGB";
    return part;
  }

  std::string read_row(std::uint8_t* row) override {
    return guarded([&] { jpeg_read_scanlines(&jpeg_, &row, 1); });
  }

 private:
  // libjpeg reports failures by longjmp (see on_error), so `work` must not hold objects with destructors.
  template <typename Work>
  std::string guarded(const Work& work) {
    message_[0] = '\0';
    if (setjmp(jump_) == 0) work();
    return message_;
  }

  static JpegStream& of(j_common_ptr jpeg) { return *static_cast<JpegStream*>(jpeg->client_data); }
  static void keep_message(j_common_ptr jpeg) {
    char text[JMSG_LENGTH_MAX] = "";
    jpeg->err->format_message(jpeg, text);
    std::snprintf(of(jpeg).message_, sizeof(of(jpeg).message_), "%s", text);
  }
  static void on_error(j_common_ptr jpeg) {
    keep_message(jpeg);
    std::longjmp(of(jpeg).jump_, 1);
  }
  // Negative levels are warnings about damaged data, which libjpeg replaces by grey.
  static void on_message(j_common_ptr jpeg, int level) {
    if (level < 0) keep_message(jpeg);
  }

  std::vector<unsigned char> bytes_;
  jpeg_decompress_struct jpeg_ = {};
  jpeg_error_mgr errors_ = {};
  std::jmp_buf jump_ = {};
  char message_[JMSG_LENGTH_MAX] = "";
};

}  // namespace

std::unique_ptr<LibraryImageFile> open_jpeg_image(const std::string& path, const ImageContainer& container) {
  const auto open = [=] { return std::make_unique<JpegStream>(path, container); };
  std::unique_ptr<JpegStream> stream = open();
  return stream->is_supported() ? make_row_image_file(container, std::move(stream), open) : nullptr;
}

}  // namespace multum
