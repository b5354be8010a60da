// SPDX-License-Identifier: Apache-2.0
// Workaround "OpenEXR 3.1 inflates by zlib". multum-decode unpacks each chunk of an EXR map a second time, to check
// that the chunk is complete (host/foundation/base/files/exr_chunks.h). The check takes one hundredth of the processor
// time of a bake. libdeflate inflates twice as fast as zlib, which compensates for the check. OpenEXR 3.1 (Debian 12)
// calls zlib's uncompress(), and a program that links this file replaces that function. No other code in the program
// calls uncompress(). Remove this file when Debian's OpenEXR has its own inflate function.
#include "host/formats/decoder/zlib_uncompress.h"

#include <libdeflate.h>
#include <zlib.h>

#include <cstddef>
#include <memory>

namespace multum {
namespace {

struct FreeInflater {
  void operator()(libdeflate_decompressor* one) const { libdeflate_free_decompressor(one); }
};

}  // namespace

bool replaces_zlib_uncompress() { return true; }

}  // namespace multum

// The program must export the function, because otherwise OpenEXR finds only zlib's (tools/check_layering --programs).
extern "C" __attribute__((visibility("default"))) int uncompress(Bytef* destination, uLongf* destination_size,
                                                                 const Bytef* source, uLong source_size) {
  static thread_local std::unique_ptr<libdeflate_decompressor, multum::FreeInflater> mine(
      libdeflate_alloc_decompressor());
  if (mine == nullptr) return Z_MEM_ERROR;
  std::size_t size = 0;
  switch (libdeflate_zlib_decompress(mine.get(), source, source_size, destination, *destination_size, &size)) {
    case LIBDEFLATE_SUCCESS: *destination_size = size; return Z_OK;
    case LIBDEFLATE_INSUFFICIENT_SPACE: return Z_BUF_ERROR;
    default: return Z_DATA_ERROR;
  }
}
