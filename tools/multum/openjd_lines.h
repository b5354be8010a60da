// SPDX-License-Identifier: Apache-2.0
// Reports progress to the agent that runs multum as a task of an Open Job Description: lines on stdout that begin with
// openjd_progress, openjd_status or openjd_fail (openjd-specifications, "How Jobs Are Run", "Stdout/Stderr Messages").
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "host/foundation/base/progress.h"

namespace multum {

/// Turns these lines on for the process.
void begin_openjd_lines();
bool has_openjd_lines();

/// The next long call is number `part`, from 0, of several similar calls: percentages count all of them.
void openjd_part(std::size_t part, std::size_t of);

/// Progress that prints at most one line per second. Ctrl-C and SIGTERM cancel.
std::unique_ptr<Progress> make_openjd_progress();

/// Prints the end of the task: 100 %, or the reason of its failure in one line.
void print_openjd_success();
void print_openjd_failure(const std::string& why);

}  // namespace multum
