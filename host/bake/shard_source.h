// SPDX-License-Identifier: Apache-2.0
// Hands the map to the processes that fit bands of it: the first share's file has its rows, as a bake reads them, so
// that the others read theirs alone, and decode nothing.
#pragma once

#include <string>

#include "host/bake/bake_job.h"
#include "host/bake/bake_source.h"
#include "host/movmf/map_shard.h"

namespace multum {

/// What a band must know of the map: sizes, wrap modes, features. A line.
std::string shard_note(const BakeSource& source);

/// The map's rows, and its features'.
void write_map_rows(const BakeSource& source, ShardWriter& writer);

/// The source of a band, JOB.shard, as far as the band covers it: other rows have no values. Of the map's report it has
/// wrap modes alone. `key`: rows_key(). Throws Error(kEnvironment) as ShardReader does.
BakeSource read_shard_source(const BakeJob& job, const std::string& key);

}  // namespace multum
