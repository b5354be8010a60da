// SPDX-License-Identifier: Apache-2.0
// SHA-256 of files, on threads of its own; what has been hashed is remembered for as long as the file has the same
// inode, size and time.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <string>

#include "host/foundation/base/files/open_file.h"

namespace multum {

class FileHashes {
 public:
  explicit FileHashes(int threads) : pool_(static_cast<std::size_t>(threads)) {}
  ~FileHashes() { pool_.join(); }

  /// Blocks. `path` is the name by which it is remembered. Throws Error(kInput) when the file cannot be read.
  std::string hash(const std::string& path, const OpenFile& file);
  boost::asio::thread_pool& pool() { return pool_; }

 private:
  struct Known {
    std::string identity, hash;
  };
  std::mutex mutex_;
  std::map<std::string, Known> known_;
  boost::asio::thread_pool pool_;
};

}  // namespace multum
