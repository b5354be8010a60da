// SPDX-License-Identifier: Apache-2.0
// Hands the map to the processes that fit bands of it, and to the one that merges them: the first share's file has its
// rows, as a bake reads them, so that the others decode nothing.
#pragma once

#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_source.h"
#include "host/bakes/movmf/map_shard.h"

namespace multum {

/// What others must know of the map: sizes, features, what was found in its files, and their hashes. A line of JSON.
std::string shard_note(const BakeJob& job, const BakeSource& source);

/// The planes of the map, and of its features, one behind the other: before any other rows of the share.
void write_map_rows(const BakeSource& source, ShareWriter& writer);

/// Takes hashes of the job's files from share 0, those of files that are as they were for it: a band is of what share 0
/// has read of them.
void take_share_hashes(const BakeJob& job);

/// The source of a band, JOB.shard, as far as the band covers it (other rows may have no values), or of the merge of
/// JOB.merged_shards. `key`: rows_key(). Throws Error(kEnvironment) as ShareFile does.
BakeSource read_shard_source(const BakeJob& job, const std::string& key);

}  // namespace multum
