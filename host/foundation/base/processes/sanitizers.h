// SPDX-License-Identifier: Apache-2.0
// Defines MULTUM_SHADOW_MEMORY if the program contains a sanitizer whose shadow memory needs terabytes of addresses.
// Such a program cannot set a memory limit, and the sanitizer reports signals with its own messages. GCC indicates
// sanitizers by macros, and clang indicates them by features.
#pragma once

#ifdef __has_feature
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MULTUM_SHADOW_MEMORY
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MULTUM_SHADOW_MEMORY
#endif
