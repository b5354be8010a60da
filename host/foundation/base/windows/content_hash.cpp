// SPDX-License-Identifier: Apache-2.0
// Implements host/foundation/base/files/content_hash.h for Windows. The library bcrypt.dll of Windows computes
// SHA-256, because Debian has no OpenSSL for mingw-w64. hash_file() is missing, because readers do not call it.
#include "host/foundation/base/files/content_hash.h"

#include <windows.h>

#include <bcrypt.h>

#include "host/foundation/base/error.h"

namespace multum {

struct ContentHash::State {
  BCRYPT_ALG_HANDLE algorithm = nullptr;
  BCRYPT_HASH_HANDLE hash = nullptr;
  ~State() {
    if (hash != nullptr) ::BCryptDestroyHash(hash);
    if (algorithm != nullptr) ::BCryptCloseAlgorithmProvider(algorithm, 0);
  }
};

ContentHash::ContentHash() : state_(std::make_unique<State>()) {
  MULTUM_CHECK(::BCryptOpenAlgorithmProvider(&state_->algorithm, BCRYPT_SHA256_ALGORITHM, nullptr, 0) == 0);
  MULTUM_CHECK(::BCryptCreateHash(state_->algorithm, &state_->hash, nullptr, 0, nullptr, 0, 0) == 0);
}
ContentHash::~ContentHash() = default;

void ContentHash::update(const void* data, std::size_t byte_count) {
  constexpr std::size_t kLargestUpdate = std::size_t{1} << 30;
  const auto* bytes = static_cast<const unsigned char*>(data);
  while (byte_count > 0) {
    const std::size_t count = byte_count < kLargestUpdate ? byte_count : kLargestUpdate;
    MULTUM_CHECK(::BCryptHashData(state_->hash, const_cast<PUCHAR>(bytes), static_cast<ULONG>(count), 0) == 0);
    bytes += count;
    byte_count -= count;
  }
}

std::string ContentHash::finish() {
  unsigned char digest[32];
  MULTUM_CHECK(::BCryptFinishHash(state_->hash, digest, sizeof(digest), 0) == 0);
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string hex;
  for (const unsigned char byte : digest) {
    hex += kDigits[byte >> 4];
    hex += kDigits[byte & 15];
  }
  return hex;
}

std::string hash_text(std::string_view text) {
  ContentHash hash;
  hash.update(text);
  return hash.finish();
}

}  // namespace multum
