// SPDX-License-Identifier: Apache-2.0
// "OpenEXR File Layout" and "Technical Introduction to OpenEXR": before a chunk is packed, its bytes at even positions
// and its bytes at odd positions are separated. Each byte is then replaced by 128 plus its difference from the byte
// before it.
#include "host/foundation/base/files/exr_unpack.h"

#include <libdeflate.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

namespace multum {
namespace {

struct CompressionRow {
  const char* name;
  int rows;
};
constexpr std::array<CompressionRow, exr_compression::kCount> kCompressionRows = {{{"none", 1},
                                                                                   {"rle", 1},
                                                                                   {"zips", 1},
                                                                                   {"zip", 16},
                                                                                   {"piz", 32},
                                                                                   {"pxr24", 16},
                                                                                   {"b44", 32},
                                                                                   {"b44a", 32},
                                                                                   {"dwaa", 32},
                                                                                   {"dwab", 256}}};

using ByteVector = unsigned char __attribute__((vector_size(16)));

// Sums the differences of 16 bytes at a time. The steps add the values 1, 2, 4 and 8 positions before.
void sum_differences(unsigned char* bytes, std::size_t size) {
  constexpr unsigned char kMiddle = 128;
  const ByteVector zero{}, middle = zero + kMiddle;
  unsigned char last = kMiddle;  // the first byte is stored as it is
  std::size_t i = 0;
  for (; i + sizeof(ByteVector) <= size; i += sizeof(ByteVector)) {
    ByteVector v;
    std::memcpy(&v, bytes + i, sizeof(v));
    v -= middle;
    v += __builtin_shufflevector(zero, v, 0, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
    v += __builtin_shufflevector(zero, v, 0, 1, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29);
    v += __builtin_shufflevector(zero, v, 0, 1, 2, 3, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27);
    v += __builtin_shufflevector(zero, v, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
    v += last;
    last = v[15];
    std::memcpy(bytes + i, &v, sizeof(v));
  }
  for (; i < size; ++i) last = bytes[i] = static_cast<unsigned char>(last + bytes[i] - kMiddle);
}

void bring_together(const unsigned char* parted, std::size_t size, unsigned char* together) {
  const unsigned char* const odd = parted + (size + 1) / 2;
  for (std::size_t i = 0; i < size / 2; ++i) {
    together[2 * i] = parted[i];
    together[2 * i + 1] = odd[i];
  }
  if (size % 2 != 0) together[size - 1] = parted[size / 2];
}

// Expands runs. A negative count is followed by that number of bytes. Any other count is followed by one byte, which is
// repeated count + 1 times.
const char* unroll(const unsigned char* packed, std::size_t packed_size, unsigned char* out, std::size_t size) {
  std::size_t at = 0;
  for (std::size_t i = 0; i < packed_size;) {
    const int count = static_cast<signed char>(packed[i++]);
    const auto length = static_cast<std::size_t>(count < 0 ? -count : count + 1);
    if (length > size - at) return "its runs unpack to too many bytes";
    if ((count < 0 ? length : 1) > packed_size - i) return "its last run is incomplete";
    if (count < 0) std::memcpy(out + at, packed + i, length);
    else std::memset(out + at, packed[i], length);
    i += count < 0 ? length : 1;
    at += length;
  }
  return at == size ? nullptr : "its runs unpack to too few bytes";
}

struct FreeDecompressor {
  void operator()(libdeflate_decompressor* one) const { libdeflate_free_decompressor(one); }
};

const char* inflate_all(const unsigned char* packed, std::size_t packed_size, unsigned char* out, std::size_t size) {
  static thread_local std::unique_ptr<libdeflate_decompressor, FreeDecompressor> mine(libdeflate_alloc_decompressor());
  if (mine == nullptr) throw std::bad_alloc();
  switch (libdeflate_zlib_decompress(mine.get(), packed, packed_size, out, size, nullptr)) {
    case LIBDEFLATE_SUCCESS: return nullptr;
    case LIBDEFLATE_SHORT_OUTPUT: return "it unpacks to too few bytes";
    case LIBDEFLATE_INSUFFICIENT_SPACE: return "it unpacks to too many bytes";
    default: return "it is not a complete zlib stream, or its checksum is wrong";
  }
}

// Returns a buffer of this thread with at least `size` bytes.
std::vector<unsigned char>& parted_bytes(std::size_t size) {
  static thread_local std::vector<unsigned char> bytes;
  if (bytes.size() < size) bytes.resize(size);
  return bytes;
}

// Unpacks a chunk to differences, in which even and odd bytes are still separated.
const char* unpack_parted(int compression, const unsigned char* packed, std::size_t packed_size, unsigned char* parted,
                          std::size_t size) {
  if (packed_size > size || compression == exr_compression::kNone)
    return "its size differs from the size of its texels";
  return compression == exr_compression::kRle ? unroll(packed, packed_size, parted, size)
                                              : inflate_all(packed, packed_size, parted, size);
}

}  // namespace

const char* exr_compression_name(int compression) {
  return compression >= 0 && compression < exr_compression::kCount
             ? kCompressionRows[static_cast<std::size_t>(compression)].name
             : "unknown";
}

int exr_rows_per_chunk(int compression) {
  return compression >= 0 && compression < exr_compression::kCount
             ? kCompressionRows[static_cast<std::size_t>(compression)].rows
             : 0;
}

const char* check_exr(int compression, const unsigned char* packed, std::size_t packed_size, std::size_t size) {
  return packed_size == size ? nullptr
                             : unpack_parted(compression, packed, packed_size, parted_bytes(size).data(), size);
}

const char* unpack_exr(int compression, const unsigned char* packed, std::size_t packed_size, unsigned char* unpacked,
                       std::size_t size) {
  if (packed_size == size) {
    std::memcpy(unpacked, packed, size);
    return nullptr;
  }
  std::vector<unsigned char>& parted = parted_bytes(size);
  const char* const wrong = unpack_parted(compression, packed, packed_size, parted.data(), size);
  if (wrong != nullptr) return wrong;
  sum_differences(parted.data(), size);
  bring_together(parted.data(), size, unpacked);
  return nullptr;
}

bool may_unpack_exr(int compression, std::size_t packed_size, std::size_t size) {
  // The largest expansion: RLE packs a run of 128 bytes into two, and deflate packs 258 bytes into 2 bits.
  const std::size_t most = compression == exr_compression::kRle ? 64 : 1032;
  return packed_size >= size ||
         (can_unpack_exr(compression) && compression != exr_compression::kNone ? size / most <= packed_size
                                                                               : compression != exr_compression::kNone);
}

}  // namespace multum
