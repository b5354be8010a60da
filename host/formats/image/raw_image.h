// SPDX-License-Identifier: Apache-2.0
// Holds the values of an image in the file's own type, in memory or in a scratch file, and returns rows as floats. The
// values need a half or a quarter of the memory of floats. They are written once, while the file is read, and are read
// several times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/plane_store.h"
#include "host/formats/image/sample_converter.h"
#include "host/foundation/base/files/scratch_file.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

enum class SampleType { kUint8, kUint16, kOtherInteger, kHalf, kFloat };  // kFloat includes double

inline bool is_float_type(SampleType type) { return type == SampleType::kHalf || type == SampleType::kFloat; }

/// The description of an image, which is known before its rows are read.
struct RawImageInfo {
  int width = 0;
  int height = 0;
  int channel_count = 0;  // number of colour channels, 1 to 3, without alpha; or number of all channels
  SampleType sample_type = SampleType::kFloat;
  int base_type = 0;                       // type of the stored samples (host/formats/image/files/number_type.h)
  std::size_t row_bytes = 0;               // bytes of a row of the stored samples
  std::string colour_space;                // name from the file: "sRGB", "Linear", "Gamma2.2", or empty
  bool has_alpha = false;                  // true if the file has alpha, which is never read
  std::vector<std::string> channel_names;  // names of the channels that are read
  std::string format;                      // "png uint8, 4 channels (alpha not read)"
  std::vector<std::string> notes = {};     // ImageContainer::notes
  double texel_metres = 0.0;               // as in ImageContainer
  std::optional<double> no_data = {};      // as in ImageContainer

  std::size_t row_values() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(channel_count); }
};

/// Rows in the sample type of the file, in row-major order with interleaved channels.
struct RawBand {
  int first_row;
  int row_count;
  const std::byte* samples;
};

/// Rows as floats (host/formats/image/sample_converter.h) with interleaved channels, and the memory for reading them.
/// Each thread needs its own object.
struct RawRows {
  std::vector<float> values;
  std::vector<std::byte> samples;
};

class RawImage {
 public:
  /// Throws Error(kEnvironment) if a scratch file is needed and cannot be made.
  RawImage(RawImageInfo info, const SpillPolicy& spill);

  const RawImageInfo& info() const { return info_; }
  /// Throws Error(kEnvironment) if the disk fails.
  void write(const RawBand& band);
  /// Reads rows. Several threads may read at once, each into its own rows.
  void read_rows(int first_row, int row_count, RawRows& rows) const;

 private:
  RawImageInfo info_;
  SampleConverter converter_;
  std::unique_ptr<std::byte[]> samples_;  // not initialized to 0
  std::optional<ScratchFile> file_;
};

}  // namespace multum
