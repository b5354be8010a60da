// SPDX-License-Identifier: Apache-2.0
#include "host/bake/bake_output.h"

#include <chrono>
#include <utility>

namespace multum {
namespace {

// Adds the time from its making to its end.
class StopWatch {
 public:
  explicit StopWatch(double& seconds) : seconds_(seconds) {}
  ~StopWatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count(); }

 private:
  double& seconds_;
  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
};

MovmfFinest row_of(const MovmfFinest& rows, int row) {
  const std::ptrdiff_t begin = std::ptrdiff_t{row} * rows.width, end = begin + rows.width;
  MovmfFinest one;
  one.width = rows.width;
  one.height = 1;
  one.representation = rows.representation;
  one.normals.assign(rows.normals.begin() + begin, rows.normals.begin() + end);
  one.lobe.assign(rows.lobe.begin() + begin, rows.lobe.begin() + end);
  if (!rows.colours.empty()) one.colours.assign(rows.colours.begin() + begin, rows.colours.begin() + end);
  return one;
}

}  // namespace

void BakeOutput::round(MovmfLevel& rows) {
  const StopWatch watch(report_.round_seconds);
  const SharpLobes sharp = count_sharp_lobes(rows, header_, threads_);
  report_.beyond_storage += sharp.count;
  report_.beyond_storage_amplitude += sharp.amplitude;
  quantize_lobes(rows, header_, threads_);
}

void BakeOutput::round(MovmfFinest& rows) {
  const StopWatch watch(report_.round_seconds);
  quantize_movmf(rows, header_.encoding, threads_);
}

void BakeOutput::write(int level, int first_row, MovmfLevel rows) {
  if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
  const StopWatch watch(report_.write_wait_seconds);
  writer_.write_level(level, first_row, std::move(rows));
}

void BakeOutput::write(int first_row, MovmfFinest rows) {
  // Full lobes are many times as large: of those rows alone that are looked at.
  for (int y = 0; meter_ != nullptr && y < rows.height; ++y)
    if (meter_->needs_rows(0, first_row + y, 1))
      meter_->add_rows(0, first_row + y, expand(row_of(rows, y), header_.lobe_count()));
  const StopWatch watch(report_.write_wait_seconds);
  writer_.write_finest(first_row, std::move(rows));
}

}  // namespace multum
