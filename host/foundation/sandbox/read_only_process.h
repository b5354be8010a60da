// SPDX-License-Identifier: Apache-2.0
// Takes from a process everything that decoding a file does not need, so that a file that takes control of the process
// can do little more than return wrong pictures. Uses Linux's seccomp, which needs no privilege and cannot be undone.
#pragma once

namespace multum {

/// Returns whether confine_to_reading() works here. The kernel needs seccomp filters, and the processor must be x86-64
/// or arm64. Builds with the address or thread sanitizer are not confined, because these sanitizers start programs.
bool can_confine_to_reading();

/// Confines this thread, and the threads that it starts, from now on. They can open files only for reading, and use the
/// descriptors that are open. They cannot change, create or remove files or their attributes, start programs or
/// processes, open sockets, raise their limits, or control other processes. A forbidden system call fails with EPERM,
/// or with another error after which a library continues without the call. Returns false if this is not possible.
bool confine_to_reading();

}  // namespace multum
