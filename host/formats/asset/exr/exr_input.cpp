// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/exr/exr_input.h"

#include <IexBaseExc.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstring>

namespace multum {

ExrInputStream::ExrInputStream(const std::string& path) : IStream(path.c_str()), stream_(path) {
  if (!stream_) throw Iex::IoExc(std::string("cannot be opened: ") + std::strerror(errno));
}

bool ExrInputStream::read(char values[], int count) {
  if (stream_.read(values, count)) return true;
  throw Iex::InputExc(fmt::format("the file ends after {} of {} bytes of a block", stream_.gcount(), count));
}

}  // namespace multum
