// SPDX-License-Identifier: Apache-2.0
#include "host/service/slurm/slurm_look.h"

#include "host/base/error.h"

namespace multum {

SlurmLook look_at_slurm(const SlurmCommands& commands, const SlurmFolder& folder, const std::string& prefix,
                        const std::vector<SlurmWatched>& watched) {
  SlurmLook look;
  try {
    look.tasks = commands.list(prefix);
  } catch (const Error& error) {
    look.trouble = error.what();
  }
  // Then the files: a task that is over by the list has written what it has to say.
  for (const SlurmWatched& part : watched) {
    const SlurmBatchFolder batch = folder.batch(part.key.first);
    SlurmLook::Seen& seen = look.parts[part.key];
    seen.end = batch.end(part.key.second);
    if (!seen.end) seen.status = batch.status(part.key.second);
    if (!seen.end && !seen.status) seen.last_words = batch.last_words(part.key.second, part.is_array);
    if (!seen.end && !seen.status) continue;
    try {
      batch.move_log(part.work_item(), part.key.second, part.log, part.log_prefix, seen.end.has_value());
    } catch (const Error&) {  // no room for it now
    }
  }
  return look;
}

}  // namespace multum
