// SPDX-License-Identifier: Apache-2.0
// Reports progress to the agent that runs multum as a task of an Open Job Description. Lines that begin with
// openjd_progress, openjd_status or openjd_fail are printed to stdout (openjd-specifications, "How Jobs Are Run",
// "Stdout/Stderr Messages").
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "host/foundation/base/progress.h"

namespace multum {

/// Turns on progress lines for this process.
void begin_openjd_lines();
bool has_openjd_lines();

/// Announces that the next long call is number `part` of several calls, counted from 0. Percentages cover all of them.
void openjd_part(std::size_t part, std::size_t of);

/// Returns a Progress that prints at most one line per second. Ctrl-C and SIGTERM cancel it.
std::unique_ptr<Progress> make_openjd_progress();

/// Prints that the task has ended. The output is 100 %, or one line with the reason why the task failed.
void print_openjd_success();
void print_openjd_failure(const std::string& why);

}  // namespace multum
