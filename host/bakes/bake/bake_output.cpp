// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_output.h"

#include <utility>

#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

MovmfFinest row_of(const MovmfFinest& rows, int row) {
  const std::size_t texels = rows.normals.size(), width = static_cast<std::size_t>(rows.width);
  const std::size_t begin = static_cast<std::size_t>(row) * width;
  const auto of_row = [&](const auto& values) { return texels_of(values, texels, begin, begin + width); };
  return {rows.width,           1,
          of_row(rows.normals), of_row(rows.lobe),
          of_row(rows.colours), of_row(rows.weights),
          rows.representation,  rows.has_roughness};
}

}  // namespace

void BakeOutput::add_level(int level, int first_row, MovmfLevel rows) {
  round(rows);
  write(level, first_row, std::move(rows));
}

void BakeOutput::add_finest(int first_row, MovmfFinest rows) {
  round(rows);
  write(first_row, std::move(rows));
}

void BakeOutput::round(MovmfLevel& rows) {
  const ScopedStopwatch watch(report_.round_seconds);
  const LobeFamily& family = lobe_family(header_.header.representation);
  const SharpLobes sharp = family.count_sharp(rows, header_.header.encoding, threads_);
  report_.unrepresentable += sharp.count;
  report_.unrepresentable_amplitude += sharp.amplitude;
  family.quantize(rows, header_.header.encoding, threads_);
}

void BakeOutput::round(MovmfFinest& rows) {
  const ScopedStopwatch watch(report_.round_seconds);
  quantize_movmf(rows, header_.header.encoding, threads_);
}

void BakeOutput::write(int level, int first_row, MovmfLevel rows) {
  if (meter_ != nullptr) meter_->add_rows(level, first_row, rows);
  const ScopedStopwatch watch(report_.write_wait_seconds);
  writer_.write_level(level, first_row, std::move(rows));
}

void BakeOutput::write(int first_row, MovmfFinest rows) {
  // Expanded lobes need many times as much memory as stored lobes, so only rows that the meter reads are expanded.
  for (int y = 0; meter_ != nullptr && y < rows.height; ++y)
    if (meter_->needs_rows(0, first_row + y, 1))
      meter_->add_rows(0, first_row + y, expand(row_of(rows, y), header_.lobe_count()));
  const ScopedStopwatch watch(report_.write_wait_seconds);
  writer_.write_finest(first_row, std::move(rows));
}

}  // namespace multum
