// SPDX-License-Identifier: Apache-2.0
// Passes the map to the processes that fit its bands and to the process that merges them. The first share's file
// contains the map's decoded rows, so that the other processes decode nothing.
#pragma once

#include <string>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_source.h"
#include "host/bakes/movmf/map_shard.h"

namespace multum {

/// Writes one line of JSON with the properties of the map that other processes need: sizes, features, hashes of its
/// files and findings about them.
std::string shard_note(const BakeJob& job, const BakeSource& source);

/// Writes the planes of the map and then the planes of its features, before any other rows of the share.
void write_map_rows(const BakeSource& source, ShareWriter& writer);

/// Takes hashes of the job's files from share 0 if the files have not changed since share 0 read them, because a band
/// uses the data that share 0 has read.
void take_share_hashes(const BakeJob& job);

/// Returns the source of the band JOB.shard, in which rows outside the band may have no values, or the source of the
/// merge of JOB.merged_shards. `key` is rows_key(). Throws Error(kEnvironment) as ShareFile does.
BakeSource read_shard_source(const BakeJob& job, const std::string& key);

}  // namespace multum
