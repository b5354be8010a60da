// SPDX-License-Identifier: Apache-2.0
// Takes from a process everything that decoding a file does not need, so that a file that takes control of the process
// can do little more than return wrong pictures. Uses Linux's seccomp, and Landlock if the kernel has it. Neither needs
// a privilege, and neither can be undone.
#pragma once

namespace multum {

/// Returns whether confine_to_reading() works here. The kernel needs seccomp filters, and the processor must be x86-64
/// or arm64. Builds with the address sanitizer cannot be confined, because the sanitizer starts programs.
bool can_confine_to_reading();

/// Confines this thread, and the threads and processes that it starts, from now on. They can open files only for
/// reading. They cannot change, create or remove files or their attributes, start programs, open sockets, or control
/// other processes. Open descriptors stay usable. A forbidden system call fails with EPERM, or with ENOSYS if a program
/// is expected to try another call then. Returns false if this is not possible.
bool confine_to_reading();

}  // namespace multum
