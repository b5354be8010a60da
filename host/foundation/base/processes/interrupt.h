// SPDX-License-Identifier: Apache-2.0
// Tells whether a signal has asked this program to stop. make_progress() in host/foundation/base/progress.h installs
// the signal handlers.
#pragma once

namespace multum {

/// Returns true after the first SIGINT or SIGTERM, in programs that handle these signals.
bool is_interrupted();

}  // namespace multum
