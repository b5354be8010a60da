// SPDX-License-Identifier: Apache-2.0
// Hashes each file that a program reads, once. The hash covers the bytes that the file had when it was first examined.
// A file that changes later is rejected.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace multum {

class InputHashes {
 public:
  /// Records the state of a file before anything reads it. Does nothing if the file cannot be examined or its state is
  /// already recorded.
  void note(const std::string& path);
  /// Returns the SHA-256, which is computed at the first call. Throws Error(kInput) if the file cannot be read, or has
  /// changed since note().
  std::string hash(const std::string& path);
  /// Throws Error(kInput) if the file has changed since note(), because data that were read since then are invalid.
  void check_unchanged(const std::string& path);
  /// The part of a file's state that is also visible on other machines.
  struct FileState {
    std::int64_t size = -1, modified_ns = 0;
    bool operator==(const FileState&) const = default;
  };
  /// The state of the file when it was first examined.
  FileState state(const std::string& path);
  /// Adopts a hash that another process computed, if the file still has the same `state` as in that process.
  void take(const std::string& path, const FileState& state, const std::string& hash);
  /// The number of files that were read in order to hash them.
  int read_count() const;

 private:
  // The stamp changes with every write. If the file is replaced, the new file has a different inode.
  struct Stamp {
    std::uint64_t device, inode;
    std::int64_t size, modified_ns, changed_ns;
    bool operator==(const Stamp&) const = default;
  };
  struct Known {
    Stamp stamp;
    std::optional<std::string> hash;
  };
  static std::optional<Stamp> stamp_of(const std::string& path);
  Known* noted(const std::string& path);
  static void check(const Known& known, const std::string& path);

  mutable std::mutex mutex_;
  std::map<std::string, Known> known_;
  int read_count_ = 0;
};

/// Returns the SHA-256 of a regular file. Returns nullopt if the name belongs to another kind of object, or if the file
/// cannot be opened. Does not wait for a pipe or read an endless device.
std::optional<std::string> hash_regular_file(const std::string& path);

}  // namespace multum
