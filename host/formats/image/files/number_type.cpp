// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/files/number_type.h"

#include <array>

namespace multum {
namespace {

struct NumberType {
  const char* name;
  std::size_t bytes;
};

constexpr std::array<NumberType, 11> kTypes = {{{"uint8", 1},
                                                {"int8", 1},
                                                {"uint16", 2},
                                                {"int16", 2},
                                                {"uint", 4},
                                                {"int", 4},
                                                {"uint64", 8},
                                                {"int64", 8},
                                                {"half", 2},
                                                {"float", 4},
                                                {"double", 8}}};

constexpr NumberType type_of(int code) {
  return is_number_type(code) ? kTypes[static_cast<std::size_t>(code - number_type::kUint8)] : NumberType{"unknown", 0};
}

}  // namespace

std::size_t number_bytes(int code) { return type_of(code).bytes; }
const char* number_name(int code) { return type_of(code).name; }

}  // namespace multum
