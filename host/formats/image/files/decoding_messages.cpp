// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/decoding_messages.h"

#include "host/foundation/sandbox/byte_message.h"

namespace multum {
namespace {

// Visits the fields of ImagePart in the order of a message.
template <typename Part, typename Action>
void for_each_number(Part& part, const Action& action) {
  for (auto* number : {&part.x, &part.y, &part.width, &part.height, &part.depth, &part.full_x, &part.full_y,
                       &part.full_width, &part.full_height, &part.tile_width, &part.tile_height, &part.alpha_channel,
                       &part.base_type, &part.rows_per_strip})
    action(*number);
}

void write(MessageWriter& out, const ImagePart& part) {
  for_each_number(part, [&](int number) { out.number(number); });
  out.number(static_cast<std::uint8_t>(part.is_deep)).text(part.colour_space).text(part.compression);
  out.number(std::uint64_t{part.channel_names.size()});
  for (const std::string& name : part.channel_names) out.text(name);
  out.number(std::uint64_t{part.channel_types.size()});
  for (const int type : part.channel_types) out.number(type);
  out.number(std::uint64_t{part.texts.size()});
  for (const auto& [name, text] : part.texts) out.text(name).text(text);
}

ImagePart read_part(MessageReader& in) {
  ImagePart part;
  for_each_number(part, [&](int& number) { number = in.number<int>(); });
  part.is_deep = in.number<std::uint8_t>() != 0;
  part.colour_space = in.text();
  part.compression = in.text();
  for (std::size_t left = in.count(); left > 0; --left) part.channel_names.push_back(in.text());
  for (std::size_t left = in.count(); left > 0; --left) part.channel_types.push_back(in.number<int>());
  for (std::size_t left = in.count(); left > 0; --left) {
    std::string name = in.text();
    part.texts[std::move(name)] = in.text();
  }
  return part;
}

}  // namespace

std::string open_answer(const ImageDescription& description) {
  MessageWriter out;
  out.number(DecodingAnswer::kDone).text(description.format).number(description.file_size);
  out.number(std::uint64_t{description.parts.size()});
  for (const ImagePart& part : description.parts) write(out, part);
  out.number(std::uint64_t{description.notes.size()});
  for (const std::string& note : description.notes) out.text(note);
  out.number(description.texel_metres);
  out.number(static_cast<std::uint8_t>(description.no_data.has_value())).number(description.no_data.value_or(0.0));
  return out.take();
}

std::string open_request(const std::string& path, const ImageFileSettings& settings) {
  return MessageWriter()
      .number(DecodingRequest::kOpenImage)
      .text(path)
      .number(settings.texel_count_max)
      .number(settings.threads)
      .number(static_cast<std::uint8_t>(settings.all_parts))
      .take();
}

std::string read_request(const PixelBlock& block, std::size_t offset) {
  MessageWriter out;
  out.number(DecodingRequest::kReadImage);
  for (const int number :
       {block.part, block.y_begin, block.y_end, block.channel_begin, block.channel_end, block.base_type})
    out.number(number);
  return out.number(std::uint64_t{offset}).take();
}

ImageDescription parse_open_answer(MessageReader& in) {
  ImageDescription description;
  description.format = in.text();
  description.file_size = in.number<std::int64_t>();
  for (std::size_t left = in.count(); left > 0; --left) description.parts.push_back(read_part(in));
  for (std::size_t left = in.count(); left > 0; --left) description.notes.push_back(in.text());
  description.texel_metres = in.number<double>();
  const bool has_no_data = in.number<std::uint8_t>() != 0;
  if (const auto no_data = in.number<double>(); has_no_data) description.no_data = no_data;
  return description;
}

std::string parse_read_answer(MessageReader& in) { return in.text(); }

}  // namespace multum
