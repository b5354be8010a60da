// SPDX-License-Identifier: Apache-2.0
// The command line program multum.
#include "host/foundation/base/error.h"
#include "tools/multum/commands.h"

int main(int argc, char** argv) {
  multum::register_jobs();
  return multum::run_guarded("multum", multum::run_command, argc, argv);
}
