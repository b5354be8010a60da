// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/exr/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include <half.h>

#include <exception>
#include <optional>

#include "host/formats/asset/exr/exr_output.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"

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

namespace {

// Converts exceptions of OpenEXR to an Error that names the file.
template <typename Work>
void writing(const std::string& path, const Work& work) {
  try {
    work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kEnvironment, path + ": cannot be written: " + error.what());
  }
}

}  // namespace

struct ExrHalfWriter::State {
  State(const std::string& path, int width_in, int height_in, int channel_count)
      : file(path), stream(file), width(width_in), height(height_in) {
    MULTUM_CHECK(channel_count == 3 || channel_count == 4);
    channels = {"R", "G", "B"};
    if (channel_count == 4) channels.push_back("A");
  }

  AtomicFile file;
  ExrOutputStream stream;
  int width, height, row = 0;  // `row` is the next row
  std::vector<const char*> channels;
  std::optional<Imf::OutputFile> output;
  std::vector<half> values;
};

ExrHalfWriter::ExrHalfWriter(const std::string& path, int width, int height, int channels)
    : state_(std::make_unique<State>(path, width, height, channels)) {
  Imf::Header header(width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const char* channel : state_->channels) header.channels().insert(channel, Imf::Channel(Imf::HALF));
  writing(path, [&] { state_->output.emplace(state_->stream, header); });
}

ExrHalfWriter::~ExrHalfWriter() = default;

void ExrHalfWriter::write_rows(int row_count, const float* interleaved) {
  State& s = *state_;
  MULTUM_CHECK(s.row + row_count <= s.height);
  const std::size_t channels = s.channels.size(), row_values = channels * static_cast<std::size_t>(s.width);
  s.values.assign(interleaved, interleaved + row_values * static_cast<std::size_t>(row_count));
  Imf::FrameBuffer frame;
  std::size_t channel = 0;
  for (const char* name : s.channels)
    frame.insert(name,
                 row_slice(Imf::HALF, s.values.data() + channel++, channels * sizeof(half), s.width, s.row, row_count));
  writing(s.file.path(), [&] {
    s.output->setFrameBuffer(frame);
    s.output->writePixels(row_count);
  });
  s.row += row_count;
}

void ExrHalfWriter::finish() {
  State& s = *state_;
  MULTUM_CHECK(s.row == s.height);
  writing(s.file.path(), [&] { s.output.reset(); });
  s.stream.close();
  s.file.commit();
}

}  // namespace multum
