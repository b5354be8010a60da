// SPDX-License-Identifier: Apache-2.0
// Takes the rows of a bake of lobes, rounds them for storage, passes them to the measurement, and writes them.
#pragma once

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/bake/bake_report.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/formats/asset/lobes/movmf_writer.h"

namespace multum {

class BakeOutput : public MovmfSink {
 public:
  /// `header` is the header of the file. `meter` is null if nothing is measured. Fills OutputReport::unrepresentable
  /// and the times for rounding and writing.
  BakeOutput(MovmfWriter& writer, MovmfMeter* meter, const MovmfMipmap& header, int threads, OutputReport& report)
      : writer_(writer), meter_(meter), header_(header), threads_(threads), report_(report) {}

  /// Rounds rows and writes them.
  void add_level(int level, int first_row, MovmfLevel rows) override;
  void add_finest(int first_row, MovmfFinest rows) override;

  /// Rounds fitted rows for storage, and counts lobes that are too sharp for the encoding.
  void round(MovmfLevel& rows);
  void round(MovmfFinest& rows);
  /// Writes rounded rows of a level (or of level 0) in order.
  void write(int level, int first_row, MovmfLevel rows);
  void write(int first_row, MovmfFinest rows);

 private:
  MovmfWriter& writer_;
  MovmfMeter* meter_;
  const MovmfMipmap& header_;
  const int threads_;
  OutputReport& report_;
};

}  // namespace multum
