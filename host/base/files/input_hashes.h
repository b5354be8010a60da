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

}  // namespace multum
