// SPDX-License-Identifier: Apache-2.0
// Tells whoever runs multum as a task of an Open Job Description how far it is: lines on stdout that begin with
// openjd_progress, openjd_status or openjd_fail (openjd-specifications, "How Jobs Are Run", "Stdout/Stderr Messages").
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "host/foundation/base/progress.h"

namespace multum {

/// From now on the program prints such lines.
void begin_openjd_lines();
bool has_openjd_lines();

/// The next long call is one of several alike, `part` from 0: a percentage counts all of them.
void openjd_part(std::size_t part, std::size_t of);

/// Progress that prints lines, seldom enough for a log. Ctrl-C and SIGTERM cancel.
std::unique_ptr<Progress> make_openjd_progress();

/// How the task ended: all of it done, or why not, in one line.
void print_openjd_success();
void print_openjd_failure(const std::string& why);

}  // namespace multum
