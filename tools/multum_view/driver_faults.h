// SPDX-License-Identifier: Apache-2.0
// OpenGL drivers do not survive a lack of memory: Mesa's end the program by a signal. So that its user is told why.
#pragma once

namespace multum {

/// From here on, where this process may take only so much memory (ulimit -v), a fault or an abort ends it with an error
/// that names the limit and with the exit code of kEnvironment. Without such a limit nothing is changed.
void explain_driver_faults();

}  // namespace multum
