// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/farm/farm_commands.h"

#include "tools/command_line/absent_commands.h"
#include "tools/multum/farm/multum_job_types.h"

namespace multum {

void register_jobs() { register_job_types(multum_job_types()); }

void add_farm_commands(CLI::App& app, int* exit_code, CheckWords check_words) {
  add_serve_commands(app, exit_code);
  add_client_commands(app, exit_code);
  add_openjd_command(app, exit_code, check_words);
  for (const char* verb : {"submit", "list", "show", "cancel", "retry", "tail", "wait", "purge"})
    add_moved_command(app, verb, std::string("jobs ") + verb);
  add_moved_command(app, "rescue", "serve --data FOLDER --rescue");
}

}  // namespace multum
