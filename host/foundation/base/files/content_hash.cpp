// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/content_hash.h"

#include <openssl/evp.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/memory_images.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {

struct ContentHash::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {
  MULTUM_CHECK(EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) == 1);
}
ContentHash::~ContentHash() = default;

void ContentHash::update(const void* data, std::size_t byte_count) {
  MULTUM_CHECK(EVP_DigestUpdate(state_->context, data, byte_count) == 1);
}

std::string ContentHash::finish() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned length = 0;
  MULTUM_CHECK(EVP_DigestFinal_ex(state_->context, digest, &length) == 1);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (unsigned i = 0; i < length; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

std::string hash_text(std::string_view text) {
  ContentHash hash;
  hash.update(text);
  return hash.finish();
}

std::string hash_file(const std::string& path) {
  if (const std::optional<MemoryImage> image = find_memory_image(path)) return hash_memory_image(*image);
  const OpenFile file = open_regular_file(path);
  if (!file.is_open()) throw Error(ErrorCode::kInput, path + ": cannot be opened: " + std::strerror(errno));
  ContentHash hash;
  std::vector<char> buffer(1 << 20);
  for (;;) {
    const ssize_t count = ::read(file.descriptor(), buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) throw Error(ErrorCode::kInput, path + ": reading failed: " + std::strerror(errno));
    if (count == 0) return hash.finish();
    hash.update(buffer.data(), static_cast<std::size_t>(count));
  }
}

}  // namespace multum
