// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/checksum.h"

#include <fmt/format.h>
#include <isa-l/crc64.h>

#include "host/foundation/base/vector_state.h"

namespace multum {

void Checksum::update(const void* data, std::size_t byte_count) {
  value_ = crc64_ecma_refl(value_, static_cast<const unsigned char*>(data), byte_count);
  leave_vector_registers();
}

std::string Checksum::text() const { return fmt::format("{:016x}", value_); }

}  // namespace multum
