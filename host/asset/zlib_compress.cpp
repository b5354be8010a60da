// SPDX-License-Identifier: Apache-2.0
// Workaround "OpenEXR 3.1 compresses by zlib": compressing by zlib takes half of a bake. OpenEXR 3.1, Debian 12's,
// calls zlib's compress2(), for which a program that links this file provides its own. Nothing else in our programs
// calls that function (libpng uses deflate()). Two libraries write the same format: ISA-L at 5 to 8 times zlib's speed
// and about its size for the quickest levels, libdeflate at twice its speed, and smaller, for the others. Goes when
// Debian's OpenEXR has a compressor of its own.
#include "host/asset/zlib_compress.h"

#include <isa-l/igzip_lib.h>
#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "host/base/vector_state.h"

namespace multum {
namespace {

constexpr int kQuickLevelMax = 3;  // ISA-L's
constexpr int kUsualLevel = 6;     // zlib's for -1

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
};

// A thread's own, of the level that it was last asked for.
struct ThreadCompressor {
  int level = 0;
  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor;
};

// The number of bytes written; 0: no room.
std::size_t compress_quickly(const Bytef* source, uLong source_size, Bytef* destination, uLong destination_size) {
  static thread_local std::vector<unsigned char> working(ISAL_DEF_LVL1_DEFAULT);
  isal_zstream stream{};  // isal_deflate_stateless_init() leaves its table of strings as it was in memory
  isal_deflate_stateless_init(&stream);
  stream.level = 1;
  stream.level_buf = working.data();
  stream.level_buf_size = static_cast<std::uint32_t>(working.size());
  stream.gzip_flag = IGZIP_ZLIB;
  stream.end_of_stream = 1;
  stream.next_in = const_cast<Bytef*>(source);
  stream.avail_in = static_cast<std::uint32_t>(source_size);
  stream.next_out = destination;
  stream.avail_out = static_cast<std::uint32_t>(destination_size);
  const int result = isal_deflate_stateless(&stream);
  leave_vector_registers();
  return result == COMP_OK ? stream.total_out : 0;
}

std::size_t compress_well(const Bytef* source, uLong source_size, Bytef* destination, uLong destination_size,
                          int level) {
  static thread_local ThreadCompressor mine;
  if (mine.compressor == nullptr || mine.level != level) {
    mine.compressor.reset(libdeflate_alloc_compressor(level));
    mine.level = level;
  }
  if (mine.compressor == nullptr) return 0;
  const std::size_t size =
      libdeflate_zlib_compress(mine.compressor.get(), source, source_size, destination, destination_size);
  if (size > 0) return size;
  // libdeflate wants a little more room than zlib does before it begins.
  std::vector<unsigned char> roomy(libdeflate_zlib_compress_bound(mine.compressor.get(), source_size));
  const std::size_t roomy_size =
      libdeflate_zlib_compress(mine.compressor.get(), source, source_size, roomy.data(), roomy.size());
  if (roomy_size > destination_size) return 0;
  std::copy_n(roomy.begin(), roomy_size, destination);
  return roomy_size;
}

}  // namespace

bool replaces_zlib_compress() { return true; }

}  // namespace multum

extern "C" int compress2(Bytef* destination, uLongf* destination_size, const Bytef* source, uLong source_size,
                         int level) {
  // ISA-L has compressed the same 32 bytes, of a coarse level's tile, in two ways; why is not known. libdeflate has
  // not, and of so little its speed does not count.
  constexpr uLong kQuickBytesMin = 4096, kQuickBytesMax = std::numeric_limits<std::uint32_t>::max();
  const bool is_quick = level >= 1 && level <= multum::kQuickLevelMax && source_size >= kQuickBytesMin &&
                        source_size <= kQuickBytesMax && *destination_size <= kQuickBytesMax;
  const std::size_t size = is_quick ? multum::compress_quickly(source, source_size, destination, *destination_size)
                                    : multum::compress_well(source, source_size, destination, *destination_size,
                                                            level < 0 ? multum::kUsualLevel : level);
  if (size == 0) return Z_BUF_ERROR;
  *destination_size = size;
  return Z_OK;
}
