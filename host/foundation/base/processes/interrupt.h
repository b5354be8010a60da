// SPDX-License-Identifier: Apache-2.0
// Tells whether a signal has asked this program to end (make_progress() in host/foundation/base/progress.h listens to
// them).
#pragma once

namespace multum {

/// True from the first SIGINT or SIGTERM on, in programs that listen to them.
bool is_interrupted();

}  // namespace multum
