// SPDX-License-Identifier: Apache-2.0
// Sink of a whole bake: rounds each row as it is done and passes it to BakeOutput.
#pragma once

#include <utility>

#include "host/bake/bake_output.h"
#include "host/movmf/movmf_fit.h"

namespace multum {

class BakeSink : public MovmfSink {
 public:
  explicit BakeSink(BakeOutput& output) : output_(output) {}

  void add_level(int level, int first_row, MovmfLevel rows) override {
    output_.round(rows);
    output_.write(level, first_row, std::move(rows));
  }
  void add_finest(int first_row, MovmfFinest rows) override {
    output_.round(rows);
    output_.write(first_row, std::move(rows));
  }

 private:
  BakeOutput& output_;
};

}  // namespace multum
