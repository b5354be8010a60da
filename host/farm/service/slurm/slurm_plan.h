// SPDX-License-Identifier: Apache-2.0
// Divides jobs into Slurm batches. Several small jobs share a task, because each task costs about half a second of its
// slot. Each share of a large map gets its own task.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/farm/service/ledger/slurm_notes.h"
#include "host/farm/service/slurm/slurm_settings.h"

namespace multum {

/// The expected cost of a job, as far as it is known in advance.
struct SlurmEstimate {
  double seconds = -1.0;              // seconds in a slot; negative if unknown
  int share_count = 0;                // number of bands of the job's map; 0 if the map is not divided
  std::vector<double> share_seconds;  // seconds for share 0, one band, and the merge
};

constexpr int kChunkJobsMax = 100;

/// Groups jobs in order. Each group has the jobs' indices in `seconds`. Small jobs share a group until they fill
/// `chunk_seconds`. Each other job is a group by itself.
std::vector<std::vector<std::size_t>> make_chunks(const std::vector<double>& seconds, double chunk_seconds);

/// Returns a time limit in the range of the settings. The limit doubles with each attempt.
std::chrono::seconds time_limit(const SlurmSettings& settings, double seconds, int attempt);

/// The meaning of a part's name. The name "" is a whole job, "3/8" is a share of its map, and "merge 8" is the merge of
/// 8 shares.
struct PartKind {
  int index = 0, count = 0;  // number of the share, and number of all shares; count 0 means the whole job
  bool is_merge = false;

  bool is_whole() const { return count == 0; }
  /// Returns whether the part is a band. The tasks of an array are bands, which wait only for share 0.
  bool is_band() const { return count > 0 && !is_merge && index > 0; }
  std::string name() const;
  /// The prefix of the part's log lines, because the logs of all shares go to one file.
  std::string log_prefix() const;
  /// Returns the option of `multum bake` for this part, or "" if it needs none.
  std::string option() const;
};
PartKind parse_part(const std::string& name);

/// The array size that is used while Slurm's MaxArraySize is unknown.
constexpr int kAnyArraySize = std::numeric_limits<int>::max();

/// Groups bands of one map into arrays whose task numbers are below `array_size_max`, which is at least 1. If the
/// bands' own numbers are low enough, makes one array with these numbers. Otherwise makes several arrays with numbers
/// from 0.
std::vector<std::vector<SlurmPart>> in_arrays(std::vector<SlurmPart> bands, int array_size_max);

/// Returns the batches that make and merge these shares in order. The first is share 0, followed by its bands in arrays
/// (in_arrays()), and the merge. The parts do not have batch numbers yet.
std::vector<std::vector<SlurmPart>> share_batches(const SlurmPart& of_job, int count, const std::vector<int>& missing,
                                                  int array_size_max);

/// Returns whether `part` must wait for `other` of the same job. Bands wait for share 0, and a merge waits for all
/// shares.
bool waits_for(const PartKind& part, const PartKind& other);

/// Returns the shares that a merge's error message asks for, read from the options in the message.
std::vector<int> named_shares(const std::string& message, int count);

}  // namespace multum
