// SPDX-License-Identifier: Apache-2.0
// Layout of headers ("OpenEXR File Layout", openexr.com). A file begins
//
//   magic (4 bytes)  version and flags (4)  header, header, ...  [empty header, if the flag says multi-part]
//   header:    attribute, attribute, ...  0
//   attribute: name 0  type 0  size (4 bytes)  value
#include "host/formats/asset/exr/exr_output.h"

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

constexpr std::uint32_t kMultiPartFlag = 0x1000;

[[noreturn]] void fail(const std::string& shown_path, const std::string& reason) {
  throw Error(ErrorCode::kEnvironment, shown_path + ": writing failed: " + reason);
}

// Reads the bytes of a file in sequence, as elements of its headers.
class HeaderCursor {
 public:
  HeaderCursor(std::FILE* file, std::string shown_path) : file_(file), shown_path_(std::move(shown_path)) {}

  std::uint32_t number() {
    unsigned char bytes[4];
    if (std::fread(bytes, 1, sizeof(bytes), file_) != sizeof(bytes)) end();
    return bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16 | std::uint32_t{bytes[3]} << 24;
  }
  std::string text() {
    std::string found;
    for (int c = std::fgetc(file_); c != 0; c = std::fgetc(file_)) {
      if (c == EOF) end();
      found += static_cast<char>(c);
    }
    return found;
  }
  void skip(std::uint32_t count) {
    if (fseeko(file_, static_cast<off_t>(count), SEEK_CUR) != 0) end();
  }
  void overwrite(const std::string& value) {
    // The C standard requires a seek between reading and writing.
    if (fseeko(file_, 0, SEEK_CUR) != 0 || std::fwrite(value.data(), 1, value.size(), file_) != value.size() ||
        fseeko(file_, 0, SEEK_CUR) != 0)
      fail(shown_path_, errno_text(errno));
  }

 private:
  [[noreturn]] void end() { fail(shown_path_, "cannot read its headers again"); }
  std::FILE* file_;
  std::string shown_path_;
};

// Fills in one header. Returns false for the empty header that ends the list.
bool fill_in_header(HeaderCursor& cursor, const std::string& shown_path, const std::string& name,
                    const std::string& text, int& found) {
  std::string attribute = cursor.text();
  if (attribute.empty()) return false;
  for (; !attribute.empty(); attribute = cursor.text()) {
    const std::string type = cursor.text();
    const std::uint32_t size = cursor.number();
    if (attribute != name || type != "string") {
      cursor.skip(size);
      continue;
    }
    if (text.size() > size)
      fail(shown_path, name + " takes " + std::to_string(text.size()) + " bytes, but the header has room for " +
                           std::to_string(size));
    cursor.overwrite(text + std::string(size - text.size(), ' '));
    ++found;
  }
  return true;
}

}  // namespace

ExrOutputStream::ExrOutputStream(const AtomicFile& file) : Imf::OStream(file.path().c_str()), file_(file) {}

// The library may discard exceptions that are thrown here, so close() throws them again.
void ExrOutputStream::write(const char values[], int count) {
  if (!file_.write(values, static_cast<std::size_t>(count))) throw std::runtime_error(file_.failure());
}

void ExrOutputStream::seekp(std::uint64_t position) {
  if (!file_.seek(position)) throw std::runtime_error(file_.failure());
}

void write_exr_file(const std::string& path, const std::function<void(Imf::OStream& stream)>& write) {
  AtomicFile file(path);
  try {
    ExrOutputStream stream(file);
    write(stream);
    stream.close();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail(path, error.what());
  }
  file.commit();
}

int fill_in_attribute(const AtomicFile& output, const std::string& name, const std::string& text) {
  const std::string& shown_path = output.path();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(output.open_path().c_str(), "r+b"),
                                                             &std::fclose);
  if (file == nullptr) fail(shown_path, errno_text(errno));
  HeaderCursor cursor(file.get(), shown_path);
  cursor.skip(4);
  const bool multi_part = (cursor.number() & kMultiPartFlag) != 0;
  int found = 0;
  while (fill_in_header(cursor, shown_path, name, text, found) && multi_part) {
  }
  if (std::fflush(file.get()) != 0) fail(shown_path, errno_text(errno));
  return found;
}

}  // namespace multum
