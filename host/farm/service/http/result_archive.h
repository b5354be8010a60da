// SPDX-License-Identifier: Apache-2.0
// A folder of results as an archive to download: pax interchange format (POSIX.1-2001), which tar, bsdtar and Python's
// tarfile read. It is written as it is sent, a piece at a time, so that neither memory nor disk holds it. Only what
// .multum-result lists goes in, beneath the folder's descriptor; a file that is not as it was published any more is no
// result, and an archive without it is none either.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/files/result_seal.h"
#include "host/farm/service/http/http_server.h"
#include "host/foundation/base/files/open_file.h"

namespace multum {

class ResultArchive : public HttpBody {
 public:
  /// Blocks. Of an open folder, whose files are named NAME/... in the archive. Throws Error(kUsage) when it was not
  /// published, or a file of it is not as it was; Error(kEnvironment) when that cannot be known.
  ResultArchive(OpenFile folder, std::string name, const ResultSeal& seal);

  std::uint64_t bytes() const override { return bytes_; }
  std::size_t memory() const override;
  /// Blocks. Throws as the constructor, when a file has changed meanwhile: what was promised cannot be sent.
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

  OpenFile folder_, open_;  // `open_`: the file that is being sent
  std::string name_, etag_;
  std::vector<File> files_;
  std::size_t next_ = 0;
  std::uint64_t bytes_ = 0, left_ = 0;  // `left_`: of the open file
  std::string pending_;                 // headers and padding, not yet sent
  std::size_t sent_ = 0;                // of `pending_`
  bool is_open_ = false, is_ended_ = false;
};

}  // namespace multum
