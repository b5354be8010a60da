// SPDX-License-Identifier: Apache-2.0
#include "host/image/png_writer.h"

#include <OpenImageIO/imageio.h>

#include "host/base/atomic_file.h"
#include "host/base/error.h"

namespace multum {

struct Png16Writer::State {
  explicit State(const std::string& path) : file(path), output(OIIO::ImageOutput::create("png")) {}

  AtomicFile file;
  std::unique_ptr<OIIO::ImageOutput> output;  // closes before the file goes
  int row = 0;                                // the next

  [[noreturn]] void fail() const {
    throw Error(ErrorCode::kEnvironment,
                file.path() + ": cannot be written: " + (output ? output->geterror() : OIIO::geterror()));
  }
};

Png16Writer::Png16Writer(const std::string& path, int width, int height, const std::string& colour_space)
    : state_(std::make_unique<State>(path)) {
  OIIO::ImageSpec spec(width, height, 3, OIIO::TypeDesc::UINT16);
  spec.attribute("png:compressionLevel", 1);  // much faster than the default
  spec.attribute("oiio:ColorSpace", colour_space);
  if (!state_->output || !state_->output->open(state_->file.temporary_path(), spec)) state_->fail();
}

Png16Writer::~Png16Writer() = default;

void Png16Writer::write_rows(int row_count, const std::uint16_t* interleaved) {
  const int row_end = state_->row + row_count;
  MULTUM_CHECK(row_end <= state_->output->spec().height);
  if (!state_->output->write_scanlines(state_->row, row_end, 0, OIIO::TypeDesc::UINT16, interleaved)) state_->fail();
  state_->row = row_end;
}

void Png16Writer::finish() {
  MULTUM_CHECK(state_->row == state_->output->spec().height);
  if (!state_->output->close()) state_->fail();
  state_->file.commit();
}

void write_png16(const std::string& path, int width, int height, const std::vector<std::uint16_t>& interleaved,
                 const std::string& colour_space) {
  MULTUM_CHECK(interleaved.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  Png16Writer writer(path, width, height, colour_space);
  writer.write_rows(height, interleaved.data());
  writer.finish();
}

}  // namespace multum
