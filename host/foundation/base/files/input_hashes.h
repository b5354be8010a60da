// SPDX-License-Identifier: Apache-2.0
// Hashes the files that a program reads, each once: the hash is that of the bytes that were there when the file was
// first looked at, and a file that changes after that is refused.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace multum {

class InputHashes {
 public:
  /// Remembers what the file is like before it is read for anything. Does nothing for a file that cannot be looked at,
  /// and for one that is known.
  void note(const std::string& path);
  /// SHA-256, read at the first call. Throws Error(kInput) when the file cannot be read, or has changed since it was
  /// noted.
  std::string hash(const std::string& path);
  /// Throws Error(kInput) when the file has changed since it was noted: what was read of it meanwhile is of no use.
  void check_unchanged(const std::string& path);
  /// What a copy of the list on another machine sees of a file too.
  struct FileState {
    std::int64_t size = -1, modified_ns = 0;
    bool operator==(const FileState&) const = default;
  };
  /// As the file was when it was first looked at.
  FileState state(const std::string& path);
  /// Takes the hash that somebody else has found, if the file is in the state that it had for them.
  void take(const std::string& path, const FileState& state, const std::string& hash);
  /// Files that were read to be hashed.
  int read_count() const;

 private:
  // What changes with every write: a file that is written anew has another inode.
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

/// SHA-256 of a regular file, by whatever name; nullopt: it is none, or cannot be opened. A pipe is not waited for, and
/// a device not read for ever.
std::optional<std::string> hash_regular_file(const std::string& path);

}  // namespace multum
