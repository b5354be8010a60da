// SPDX-License-Identifier: Apache-2.0
// Copies the file of a map. Reading a map needs nothing of this file, so builds that only read files leave it out.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <vector>

#include "host/api/api_call.h"
#include "host/api/api_error.h"
#include "host/api/api_map.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

// Appends the bytes of a file to an open file. `shown` is the name of the open file in messages.
void copy_bytes(const ByteFile& file, int to, const std::string& shown) {
  constexpr std::int64_t kBlock = std::int64_t{1} << 20;
  std::vector<char> block(static_cast<std::size_t>(std::min(kBlock, file.size())));
  for (std::int64_t position = 0; position < file.size();) {
    const std::int64_t count = std::min(kBlock, file.size() - position);
    file.read(position, count, block.data(), "texels");
    for (std::int64_t done = 0; done < count;) {
      const ssize_t written = ::write(to, block.data() + done, static_cast<std::size_t>(count - done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) fail_by_errno(shown, "cannot be written");
      done += written;
    }
    position += count;
  }
}

}  // namespace
}  // namespace multum

using multum::guarded;

multum_status multum_map_save(multum_map* map, const char* path, multum_error** error) {
  return guarded(error, [&] {
    multum::require(map, "multum_map_save", "map", "a map");
    multum::require(path, "multum_map_save", "path", "the name of a file to write");
    const multum::ApiCall call(nullptr);
    const multum::NewFolders new_folders;
    multum::make_folder_of(path);
    multum::AtomicFile file(path);
    multum::copy_bytes(map->file(), file.descriptor(), path);
    file.commit();
  });
}
