// SPDX-License-Identifier: Apache-2.0
// Makes an archive of a result folder for download, in the pax interchange format (POSIX.1-2001), which tar, bsdtar and
// Python's tarfile read. The archive is made piece by piece while it is sent, and is stored neither in memory nor on
// disk. The archive contains only the files in .multum-result, read beneath the folder's descriptor. If a file has
// changed since it was published, no archive is made.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/files/result_seal.h"
#include "host/farm/service/http/http_server.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

class ResultArchive : public HttpBody {
 public:
  /// Blocks. Archives an open folder. Its files are named NAME/... in the archive. Throws Error(kUsage) when the folder
  /// was not published, or when a file has changed. Throws Error(kEnvironment) when this cannot be determined.
  ResultArchive(OpenFile folder, std::string name, const ResultSeal& seal);

  std::uint64_t bytes() const override { return bytes_; }
  std::size_t memory() const override;
  /// Blocks. Throws like the constructor if a file has changed meanwhile, because the announced bytes cannot be sent.
  std::size_t read(char* to, std::size_t bytes_max) override;
  std::string etag() const override { return etag_; }
  void skip(std::uint64_t bytes) override;

 private:
  struct File {
    std::string path, state;
  };
  std::string header(const File& file) const;
  std::size_t advance(char* to, std::uint64_t bytes_max);
  void begin_next();
  void end_file();

  OpenFile folder_, open_;  // `open_` is the file that is being sent
  std::string name_, etag_;
  std::vector<File> files_;
  std::size_t next_ = 0;
  std::uint64_t bytes_ = 0, left_ = 0;  // `left_` is the rest of the open file
  std::string pending_;                 // headers and padding, not yet sent
  std::size_t sent_ = 0;                // bytes of `pending_` that are sent
  bool is_open_ = false, is_ended_ = false;
};

}  // namespace multum
