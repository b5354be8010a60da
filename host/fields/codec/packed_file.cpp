// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/packed_file.h"

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/decoder/packed_index.h"
#include "host/fields/codec/decoder/section_checksum.h"

namespace multum {

std::vector<std::uint8_t> packed_file(const std::vector<SectionSource>& sections) {
  ByteWriter index;
  index.number(sections.size());
  for (const SectionSource& section : sections) {
    index.number(section.kind);
    index.number(section.layer);
    index.number(section.block);
    index.number(section.bytes.size());
    index.fixed(section_checksum(section.bytes), 4);
  }
  ByteWriter file;
  for (const char letter : {'M', 'P', 'T', 'F'}) file.byte(static_cast<std::uint8_t>(letter));
  file.byte(PackedIndex::kVersion);
  file.fixed(index.written().size(), 4);
  file.bytes(index.written());
  file.fixed(section_checksum(file.written()), 4);
  for (const SectionSource& section : sections) file.bytes(section.bytes);
  return file.written();
}

}  // namespace multum
