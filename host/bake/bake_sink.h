// SPDX-License-Identifier: Apache-2.0
// Where a bake's rows go as they are done: rounded, counted, kept where the measurement looks, and into the file.
#pragma once

#include "host/asset/movmf_writer.h"
#include "host/bake/accuracy.h"
#include "host/bake/bake_report.h"
#include "host/bake/movmf_fit.h"

namespace multum {

class BakeSink : public MovmfSink {
 public:
  /// `meter` is null when nothing is measured. Fills BakeReport::beyond_storage and round_seconds.
  BakeSink(MovmfWriter& writer, AccuracyMeter* meter, const MovmfMipmap& header, int threads, BakeReport& report)
      : writer_(writer),
        meter_(meter),
        encoding_(header.encoding),
        header_(header),
        threads_(threads),
        report_(report) {}

  void add_level(int level, int first_row, MovmfLevel rows) override;
  void add_finest(int first_row, MovmfFinest rows) override;

 private:
  MovmfWriter& writer_;
  AccuracyMeter* meter_;
  const StorageEncoding encoding_;
  const MovmfMipmap& header_;
  const int threads_;
  BakeReport& report_;
};

}  // namespace multum
