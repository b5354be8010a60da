// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_look.h"

#include <set>

#include "host/foundation/base/error.h"

namespace multum {

SlurmLook look_at_slurm(const SlurmCommands& commands, const SlurmFolder& folder, const std::string& prefix,
                        const std::vector<SlurmWatched>& watched) {
  SlurmLook look;
  // Reads the files after the list. If the list shows that a task has ended, the task has then written all of its
  // files.
  try {
    look.tasks = commands.list(prefix);
  } catch (const Error& error) {
    look.trouble = error.what();
  }
  look_at_files(folder, watched, look.parts);
  return look;
}

void look_at_files(const SlurmFolder& folder, const std::vector<SlurmWatched>& watched,
                   std::map<SlurmPartKey, SlurmLook::Seen>& parts) {
  std::set<std::string> names;  // file names of the batch listed last
  std::int64_t listed = 0;
  std::optional<std::string> last_words;  // last line of the task that does the whole batch
  for (const SlurmWatched& part : watched) {
    const SlurmBatchFolder batch = folder.batch(part.key.first);
    if (listed != part.key.first) {
      names = batch.names();
      last_words.reset();
    }
    listed = part.key.first;
    SlurmLook::Seen& seen = parts[part.key];
    const int item = part.key.second;
    if (names.contains(SlurmBatchFolder::end_name(item))) seen.end = batch.end(item);
    if (!seen.end && names.contains(SlurmBatchFolder::status_name(item))) seen.status = batch.status(item);
    if (!seen.end && !seen.status) {
      if (part.is_array) last_words.reset();  // each part has its own task
      if (!last_words)
        last_words = names.contains(SlurmBatchFolder::output_name(item, part.is_array))
                         ? batch.last_words(item, part.is_array)
                         : "";
      seen.last_words = *last_words;
      continue;
    }
    try {
      batch.move_log(part.work_item(), part.key.second, part.log, part.log_prefix, seen.end.has_value());
    } catch (const Error&) {  // no space at present
    }
  }
}

}  // namespace multum
