// SPDX-License-Identifier: Apache-2.0
// Codes all chunks of a field for one worth of a bit after another.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/fields/codec/field_source.h"
#include "host/fields/codec/packing/packing_journal.h"
#include "host/foundation/base/processes/memory_gate.h"

namespace multum {

struct FieldCoderSettings {
  PyramidChoice pyramid = PyramidChoice::kAdaptive;
  std::optional<ImageCoder> coder;  // the best of all when not given
  bool open_loop = false;
  double alpha = 0.0;  // as FieldPackSettings has it
  int threads = 0;
  std::uint64_t memory_bytes = 0;         // for textures and what codes them
  ImageTransforms* transforms = nullptr;  // null: those without a device
  PackingJournal* journal = nullptr;      // null: none
};

/// Everything coded for one lambda.
struct FieldRound {
  double lambda = 0.0, mse = 0.0;
  std::vector<double> object_mse;  // of each object's pixels
  double mse_covered = 0.0;
  std::vector<EncodedChunk> chunks;
  std::vector<std::uint8_t> file;
};

class FieldCoder {
 public:
  static constexpr double kLambdaMin = 1e-4, kLambdaMax = 1e9;

  /// What is passed must outlive it. Throws Error(kUsage) when a chunk alone takes more than the memory that it may.
  FieldCoder(const FieldSource& source, const std::vector<std::uint8_t>& description,
             const FieldCoderSettings& settings, Progress* progress);

  FieldRound code(double lambda);
  double lambda_of(std::size_t object, double lambda) const;
  int rounds() const { return rounds_; }
  std::size_t chunks_resumed() const { return chunks_resumed_; }

  /// Lowers the share of lambda of each object whose error is above alpha times the mean. False: there is none.
  bool hold(const FieldRound& round);

  /// Bytes that coding this chunk takes, beside its textures.
  static std::uint64_t bytes_of(const ChunkToCode& chunk, bool open_loop);

 private:
  /// Of a round before, kept while lambda stays near.
  struct KeptChunk {
    ChosenChunk chosen;
    double lambda = 0.0;     // it was coded with
    double chosen_at = 0.0;  // lambda at which all candidates were tried; 0: never
  };

  void code_chunks(const std::vector<std::size_t>& numbers, double lambda);
  /// `before`: choices to be kept; null: all are tried.
  ChosenChunk coded(std::size_t number, const ChunkSettings* before, double lambda);
  const ChunkSource& textures_of(std::size_t number, std::optional<ChunkSource>& own);
  double object_mse(std::size_t object) const;
  void hold_object(std::size_t object, double lambda, double mse, double mse_max);
  void advance(std::uint64_t units);

  const FieldSource& source_;
  const std::vector<std::uint8_t>& description_;
  const FieldCoderSettings settings_;
  Progress* progress_;
  std::mutex progress_mutex_;
  std::optional<MemoryGate> gate_;
  bool keeps_textures_ = false;
  std::vector<std::optional<ChunkSource>> textures_;  // of each chunk, while they are kept
  std::vector<ChunkCandidates> candidates_;           // of each chunk
  std::vector<KeptChunk> kept_;                       // the same
  std::vector<double> shares_;                        // of lambda, of each object, up to 1
  std::atomic<std::size_t> chunks_resumed_ = 0;
  int rounds_ = 0;
};

}  // namespace multum
