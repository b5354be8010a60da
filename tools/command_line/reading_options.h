// SPDX-License-Identifier: Apache-2.0
// The options that say what a map's numbers mean: the same in every program that reads one.
#pragma once

#include <CLI/CLI.hpp>

#include "host/image/reading_options.h"

namespace multum {

/// --help shows what `options` hold already as the defaults; it names none when they are empty.
void add_reading_options(CLI::App& app, ReadingOptions& options);

}  // namespace multum
