// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/row_image_file.h"

#include <cstring>
#include <utility>
#include <vector>

#include "host/formats/image/files/number_type.h"

namespace multum {
namespace {

class RowImageFile : public LibraryImageFile {
 public:
  RowImageFile(const ImageContainer& container, std::unique_ptr<RowStream> stream, RowStreamOpener reopen)
      : stream_(std::move(stream)), reopen_(std::move(reopen)) {
    description_ = {container.format, container.file_size, {stream_->part()}, container.notes, 0.0};
    texel_bytes_ = part().texel_bytes();
    row_bytes_ = static_cast<std::size_t>(part().width) * texel_bytes_;
  }

  std::string read_into(const PixelBlock& block, std::byte* memory) override {
    if (block.base_type != part().base_type) return "cannot convert its texels to this number type";
    const std::size_t value_bytes = number_bytes(block.base_type);
    const auto first = static_cast<std::size_t>(block.channel_begin) * value_bytes;
    const auto wanted = static_cast<std::size_t>(block.channel_end - block.channel_begin) * value_bytes;
    if (block.y_begin < next_row_) {
      stream_ = reopen_();
      next_row_ = 0;
    }
    for (row_.resize(row_bytes_); next_row_ < block.y_begin;)
      if (std::string message = read_row(row_.data()); !message.empty()) return message;
    for (int y = block.y_begin; y < block.y_end; ++y) {
      const bool is_whole = wanted == texel_bytes_;
      std::uint8_t* const row = is_whole ? reinterpret_cast<std::uint8_t*>(memory) : row_.data();
      if (std::string message = read_row(row); !message.empty()) return message;
      if (is_whole) {
        memory += row_bytes_;
        continue;
      }
      for (std::size_t at = first; at < row_bytes_; at += texel_bytes_, memory += wanted)
        std::memcpy(memory, row_.data() + at, wanted);
    }
    return "";
  }

 private:
  std::string read_row(std::uint8_t* row) {
    ++next_row_;
    return stream_->read_row(row);
  }

  std::unique_ptr<RowStream> stream_;
  RowStreamOpener reopen_;
  std::size_t texel_bytes_ = 0, row_bytes_ = 0;
  std::vector<std::uint8_t> row_;
  int next_row_ = 0;
};

}  // namespace

std::unique_ptr<LibraryImageFile> make_row_image_file(const ImageContainer& container,
                                                      std::unique_ptr<RowStream> stream, RowStreamOpener reopen) {
  return std::make_unique<RowImageFile>(container, std::move(stream), std::move(reopen));
}

}  // namespace multum
