// SPDX-License-Identifier: Apache-2.0
// Explains crashes of OpenGL drivers to the user. Drivers do not survive a lack of memory: Mesa's drivers end the
// program by a signal.
#pragma once

namespace multum {

/// Installs signal handlers if this process has a memory limit (ulimit -v). A later fault or abort then prints an error
/// that names the limit, and exits with the code of kEnvironment. Without such a limit nothing changes.
void explain_driver_faults();

}  // namespace multum
