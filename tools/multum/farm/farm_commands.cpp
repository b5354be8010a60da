// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/farm/farm_commands.h"

#include "tools/multum/farm/multum_job_types.h"

namespace multum {

void register_jobs() { register_job_types(multum_job_types()); }

void add_farm_commands(CLI::App& app, int* exit_code, CheckWords check_words) {
  app.description(
      app.get_description() +
      "\n  multum serve --data jobs                            run a service that bakes what clients submit");
  add_openjd_command(app, exit_code, check_words);
  add_serve_commands(app, exit_code);
  add_client_commands(app, exit_code);
}

}  // namespace multum
