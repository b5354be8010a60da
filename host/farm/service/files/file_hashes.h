// SPDX-License-Identifier: Apache-2.0
// Computes SHA-256 hashes of files on its own threads. Remembers a hash as long as the file has the same inode, size
// and time.
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

  /// Blocks. Remembers the hash under the name `path`. Throws Error(kInput) when the file cannot be read.
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
