// SPDX-License-Identifier: Apache-2.0
// multum: the command line.
#include "host/base/error.h"
#include "tools/multum/commands.h"

int main(int argc, char** argv) {
  const auto run = [](int count, char** words) { return multum::run_command({words + 1, words + count}, nullptr); };
  return multum::run_guarded("multum", run, argc, argv);
}
