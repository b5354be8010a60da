// SPDX-License-Identifier: Apache-2.0
// Codes all chunks of a field for a sequence of lambdas.
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
  std::optional<ImageCoder> coder;  // if unset, the best of all coders
  bool open_loop = false;
  double alpha = 0.0;  // as in FieldPackSettings
  int threads = 0;
  std::uint64_t memory_bytes = 0;         // memory for textures and their coding
  ImageTransforms* transforms = nullptr;  // if null, transforms run without a device
  PackingJournal* journal = nullptr;      // if null, no chunk is kept
};

/// The result of coding the field with one lambda.
struct FieldRound {
  double lambda = 0.0, mse = 0.0;
  std::vector<double> object_mse;  // mean squared errors over each object's pixels
  double mse_covered = 0.0;
  std::vector<EncodedChunk> chunks;
  std::vector<std::uint8_t> file;
};

class FieldCoder {
 public:
  static constexpr double kLambdaMin = 1e-4, kLambdaMax = 1e9;

  /// All arguments must outlive this object. Throws Error(kUsage) if a single chunk needs more than the allowed memory.
  FieldCoder(const FieldSource& source, const std::vector<std::uint8_t>& description,
             const FieldCoderSettings& settings, Progress* progress);

  FieldRound code(double lambda);
  double lambda_of(std::size_t object, double lambda) const;
  int rounds() const { return rounds_; }
  std::size_t chunks_resumed() const { return chunks_resumed_; }

  /// Lowers the lambda of each object whose error is above alpha times the mean. Returns false if there is no such
  /// object.
  bool hold(const FieldRound& round);

  /// Returns the memory for coding this chunk, without its textures, in bytes.
  static std::uint64_t bytes_of(const ChunkToCode& chunk, bool open_loop);

 private:
  /// A chunk of an earlier round, kept as long as lambda changes little.
  struct KeptChunk {
    ChosenChunk chosen;
    double lambda = 0.0;     // lambda with which the chunk was coded
    double chosen_at = 0.0;  // lambda at which all candidates were tried; 0 if this never happened
  };

  void code_chunks(const std::vector<std::size_t>& numbers, double lambda);
  /// Keeps the choices in `before`, or tries all candidates if `before` is null.
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
  std::vector<std::optional<ChunkSource>> textures_;  // textures by chunk, while they are kept
  std::vector<ChunkCandidates> candidates_;           // candidates by chunk
  std::vector<KeptChunk> kept_;                       // results of earlier rounds, by chunk
  std::vector<double> shares_;                        // by object: the factor of lambda, at most 1
  std::atomic<std::size_t> chunks_resumed_ = 0;
  int rounds_ = 0;
};

}  // namespace multum
