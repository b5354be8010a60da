// SPDX-License-Identifier: Apache-2.0
// Workaround "OpenEXR 3.1 compresses by zlib": compressing takes half of a bake, and libdeflate writes the same format
// at nearly twice the speed, and smaller. OpenEXR 3.2 uses it by itself; 3.1, Debian 12's, calls zlib's compress2(),
// for which a program that links this file provides its own. Nothing else in our programs calls that function (libpng
// uses deflate()). Goes when Debian's OpenEXR has it.
#include "host/asset/zlib_compress.h"

#include <libdeflate.h>
#include <zlib.h>

#include <memory>

namespace multum {
namespace {

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const { libdeflate_free_compressor(compressor); }
};

// A thread's own, of the level that it was last asked for.
struct ThreadCompressor {
  int level = 0;
  std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor;
};

}  // namespace

bool compresses_by_libdeflate() { return true; }

}  // namespace multum

extern "C" int compress2(Bytef* destination, uLongf* destination_size, const Bytef* source, uLong source_size,
                         int level) {
  static thread_local multum::ThreadCompressor mine;
  constexpr int kUsualLevel = 6;  // zlib's for -1
  const int wanted = level < 0 ? kUsualLevel : level;
  if (mine.compressor == nullptr || mine.level != wanted) {
    mine.compressor.reset(libdeflate_alloc_compressor(wanted));
    mine.level = wanted;
  }
  if (mine.compressor == nullptr) return Z_MEM_ERROR;
  const std::size_t size =
      libdeflate_zlib_compress(mine.compressor.get(), source, source_size, destination, *destination_size);
  if (size == 0) return Z_BUF_ERROR;
  *destination_size = size;
  return Z_OK;
}
