// SPDX-License-Identifier: Apache-2.0
#include "host/formats/decoder/image_decoder.h"

#include "host/formats/image/files/decoding_messages.h"
#include "host/foundation/base/error.h"
#include "host/foundation/sandbox/byte_message.h"

namespace multum {

std::string ImageDecoder::answer(std::string_view request, SharedMemory& memory) {
  MessageReader in(request);
  if (DecodingRequest{in.number<std::uint8_t>()} == DecodingRequest::kOpenImage) {
    close();
    ImageFileSettings settings;
    const std::string path = in.text();
    settings.texel_count_max = in.number<std::int64_t>();
    settings.threads = in.number<int>();
    settings.all_parts = in.number<std::uint8_t>() != 0;
    file_ = opener_(path, settings);
    return file_ != nullptr ? open_answer(file_->description()) : "";
  }
  PixelBlock block;
  for (int* number :
       {&block.part, &block.y_begin, &block.y_end, &block.channel_begin, &block.channel_end, &block.base_type})
    *number = in.number<int>();
  const auto offset = static_cast<std::size_t>(in.number<std::uint64_t>());
  std::size_t byte_count = 0;
  std::byte* const data = memory.see(byte_count);
  MULTUM_CHECK(file_ != nullptr && offset <= byte_count);
  MULTUM_CHECK(block_bytes(file_->part(block.part), block) <= byte_count - offset);
  return MessageWriter().number(DecodingAnswer::kDone).text(file_->read_into(block, data + offset)).take();
}

}  // namespace multum
