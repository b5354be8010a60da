// SPDX-License-Identifier: Apache-2.0
// Shares out jobs among batches of Slurm's: small ones several to a task, since a task costs about half a second of its
// slot whatever it does; large maps a share a task.
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

/// What a job will take, as far as that is known before.
struct SlurmEstimate {
  double seconds = -1.0;              // of a slot; below 0: not known
  int share_count = 0;                // bands that its map is divided into; 0: it is not
  std::vector<double> share_seconds;  // of share 0, a band, the merge
};

constexpr int kChunkJobsMax = 100;

/// Groups of jobs, by their places in `seconds`, in order: of those known to be small as many as fill `chunk_seconds`,
/// others alone.
std::vector<std::vector<std::size_t>> make_chunks(const std::vector<double>& seconds, double chunk_seconds);

/// Within what the settings allow; doubled with each attempt.
std::chrono::seconds time_limit(const SlurmSettings& settings, double seconds, int attempt);

/// What a part's name says: "" is all of a job, "3/8" a share of its map, "merge 8" the merge of them.
struct PartKind {
  int index = 0, count = 0;  // of a share; count 0: all of the job
  bool is_merge = false;

  bool is_whole() const { return count == 0; }
  /// Tasks of an array are bands, which wait for share 0 alone.
  bool is_band() const { return count > 0 && !is_merge && index > 0; }
  std::string name() const;
  /// Before lines of its log: those of all shares go to one.
  std::string log_prefix() const;
  /// The option of `multum bake` that does it; "": none.
  std::string option() const;
};
PartKind parse_part(const std::string& name);

/// Of Slurm's arrays while nothing is known of its MaxArraySize.
constexpr int kAnyArraySize = std::numeric_limits<int>::max();

/// Bands of one map as arrays whose numbers stay below `array_size_max`, at least 1: one array where they fit, with
/// their own numbers, else several with numbers from 0.
std::vector<std::vector<SlurmPart>> in_arrays(std::vector<SlurmPart> bands, int array_size_max);

/// The batches that make these shares, in order, and merge them: share 0, its bands in arrays (in_arrays()), the merge.
/// Parts have no number of their batch yet.
std::vector<std::vector<SlurmPart>> share_batches(const SlurmPart& of_job, int count, const std::vector<int>& missing,
                                                  int array_size_max);

/// Does a part wait until another one of the same job has ended? Bands for share 0, a merge for all shares.
bool waits_for(const PartKind& part, const PartKind& other);

/// Shares that a merge's message says to make, as it names the options for them.
std::vector<int> named_shares(const std::string& message, int count);

}  // namespace multum
