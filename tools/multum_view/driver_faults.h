// SPDX-License-Identifier: Apache-2.0
// Explains crashes of OpenGL drivers to the user. If memory runs out, Mesa's drivers terminate the program with a
// signal.
#pragma once

namespace multum {

/// Installs signal handlers if this process has a memory limit (ulimit -v). Otherwise does nothing. After a fault or
/// abort, the handlers print an error that names the limit, and exit with the code of kEnvironment.
void explain_driver_faults();

}  // namespace multum
