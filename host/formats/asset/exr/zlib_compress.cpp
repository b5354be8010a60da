// SPDX-License-Identifier: Apache-2.0
// Workaround "OpenEXR 3.1 compresses by zlib". zlib takes a third of a bake's processor time: 6.0 of 19 s for 4096 x
// 4096 texels on 2 cores of an AMD EPYC. With this file, compression takes 1.0 of 14 s; with libdeflate only, it takes
// 2.6 of 16 s. OpenEXR 3.1 (Debian 12) calls zlib's compress2(), and a program that links this file replaces that
// function. No other code in our programs calls compress2() (libpng uses deflate()). Instead of zlib, two other
// libraries write the same format. ISA-L handles the fastest levels, 5 to 8 times faster than zlib and with about the
// same size. libdeflate handles the other levels, twice as fast as zlib and with a smaller size. Remove this file when
// Debian's OpenEXR has a compressor of its own.
#include "host/formats/asset/exr/zlib_compress.h"

#include <isa-l/igzip_lib.h>
#include <libdeflate.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "host/foundation/base/vector_state.h"

namespace multum {
namespace {

constexpr int kQuickLevelMax = 3;  // levels above use libdeflate
constexpr int kDefaultLevel = 6;   // level that zlib uses for -1

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
};

// The compressor of one thread, for the most recently used level.
struct ThreadCompressor {
  int level = 0;
  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor;
};

// Returns the number of bytes written, or 0 if there is not enough room.
//
// Workaround "ISA-L 2.30 hashes its own address" (2.32 has the fault too). At the start of a stream, the long loop of
// levels 1 and 2 enters its third string into the hash table under a wrong hash (igzip_icf_body_h1_gr_bt.asm,
// .write_first_byte). The loop hashes `rcx >> 16`, but at this point rcx is the address of the stream, not the data.
// Therefore the same bytes found other matches if the stack had another address. This happened in 1 of 5000 tiles of 4
// KiB or more, and in 1 of 500 tiles of 40 bytes. The loop for the last bytes of a stream does not have this fault.
// With a flush, that loop takes the first four bytes, at a cost of about 10 bytes per tile. Test:
// ZlibCompressTest.SameBytesWhereverTheStackIs.
std::size_t compress_quickly(const Bytef* source, uLong source_size, Bytef* destination, uLong destination_size) {
  constexpr uLong kFirstBytes = 4;
  static thread_local std::vector<unsigned char> working(ISAL_DEF_LVL1_DEFAULT);
  isal_zstream stream{};
  isal_deflate_init(&stream);  // used because isal_deflate_stateless_init leaves hist_bits (the window) uninitialized
  stream.level = 1;
  stream.level_buf = working.data();
  stream.level_buf_size = static_cast<std::uint32_t>(working.size());
  stream.gzip_flag = IGZIP_ZLIB;
  stream.next_in = const_cast<Bytef*>(source);
  stream.next_out = destination;
  stream.avail_out = static_cast<std::uint32_t>(destination_size);
  const uLong first = std::min(source_size, kFirstBytes);
  stream.avail_in = static_cast<std::uint32_t>(first);
  stream.flush = SYNC_FLUSH;
  int result = isal_deflate(&stream);
  if (result == COMP_OK && stream.avail_in == 0) {
    stream.avail_in = static_cast<std::uint32_t>(source_size - first);
    stream.flush = NO_FLUSH;
    stream.end_of_stream = 1;
    result = isal_deflate(&stream);
  }
  leave_vector_registers();
  return result == COMP_OK && stream.internal_state.state == ZSTATE_END ? stream.total_out : 0;
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
  // libdeflate needs a little more room than zlib before it begins.
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

// Programs must export the function, because otherwise OpenEXR finds only zlib's (tools/check_layering --programs).
extern "C" __attribute__((visibility("default"))) int compress2(Bytef* destination, uLongf* destination_size,
                                                                const Bytef* source, uLong source_size, int level) {
  constexpr uLong kQuickBytesMax = std::numeric_limits<std::uint32_t>::max();
  const bool is_quick = level >= 1 && level <= multum::kQuickLevelMax && source_size <= kQuickBytesMax &&
                        *destination_size <= kQuickBytesMax;
  std::size_t size = is_quick ? multum::compress_quickly(source, source_size, destination, *destination_size) : 0;
  // With ISA-L, data that cannot be compressed need a few bytes more than compressBound().
  if (size == 0)
    size = multum::compress_well(source, source_size, destination, *destination_size,
                                 level < 0 ? multum::kDefaultLevel : level);
  if (size == 0) return Z_BUF_ERROR;
  *destination_size = size;
  return Z_OK;
}
