// SPDX-License-Identifier: Apache-2.0
// Declares the POSIX functions and constants that mingw-w64 lacks and that the readers of baked files use. A build for
// Windows includes this header before each source file of the readers, so the sources need no second variant.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <climits>
#include <csignal>
#include <cstddef>

// Windows would change line ends in files that are opened without _O_BINARY. Every descriptor of the readers is opened
// with O_CLOEXEC.
#define O_CLOEXEC (_O_NOINHERIT | _O_BINARY)
// On Windows, opening a file never waits for a writer, and never makes a terminal the controlling terminal.
#define O_NONBLOCK 0
#define O_NOCTTY 0
#define S_ISSOCK(mode) false

// Only F_DUPFD_CLOEXEC does something: the other commands change flags that Windows does not have.
#define F_SETFL 1
#define F_DUPFD_CLOEXEC 2
int fcntl(int descriptor, int command, int argument);

/// Reads from a position. Several threads can read from one descriptor at once.
ssize_t pread(int descriptor, void* memory, std::size_t byte_count, off_t position);

/// Fails always: readers use it only for names below /proc.
ssize_t readlink(const char* path, char* memory, std::size_t byte_count);

/// Sets an environment variable of this process.
int setenv(const char* name, const char* value, int replace);

// Replaces a handler by signal(), which keeps no flags. As in POSIX, the struct and the function have one name, so GCC
// warns that the function hides the struct's constructor.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wshadow"
struct sigaction {
  void (*sa_handler)(int);
};
int sigaction(int number, const struct sigaction* action, struct sigaction* former);
#pragma GCC diagnostic pop

// Windows has no limit of the file size, so this signal is never raised. SIGINT is a number that signal() accepts.
#define SIGXFSZ SIGINT
