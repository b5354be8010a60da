// SPDX-License-Identifier: Apache-2.0
// multum-drill is multum with one additional type of job. Its daemon starts workers and other children from the same
// program.
#include "host/foundation/base/error.h"
#include "tests/service/drill/drill_job.h"
#include "tools/multum/commands.h"
#include "tools/multum/farm/multum_job_types.h"

int main(int argc, char** argv) {
  std::vector<multum::JobType> types = multum::multum_job_types();
  types.push_back(multum::drill_job_type());
  multum::register_job_types(std::move(types));
  return multum::run_guarded("multum", multum::run_command, argc, argv);
}
