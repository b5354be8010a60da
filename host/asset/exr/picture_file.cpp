// SPDX-License-Identifier: Apache-2.0
#include "host/asset/exr/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include "host/asset/exr/exr_output.h"
#include "host/base/error.h"

namespace multum {

void write_exr_picture(const std::string& path, int width, int height, const std::vector<float>& rgba) {
  MULTUM_CHECK(rgba.size() == 4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Imf::Header header(width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer frame;
  constexpr std::size_t kTexelBytes = 4 * sizeof(float);
  std::size_t offset = 0;
  for (const char* channel : {"R", "G", "B", "A"}) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
    char* const begin = reinterpret_cast<char*>(const_cast<float*>(rgba.data())) + offset;
    frame.insert(channel, Imf::Slice(Imf::FLOAT, begin, kTexelBytes, kTexelBytes * static_cast<std::size_t>(width)));
    offset += sizeof(float);
  }
  write_exr_file(path, [&](Imf::OStream& stream) {
    Imf::OutputFile output(stream, header);
    output.setFrameBuffer(frame);
    output.writePixels(height);
  });
}

}  // namespace multum
