// SPDX-License-Identifier: Apache-2.0
// Computes SHA-256, so that users can check the hashes in headers with sha256sum.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace multum {

class ContentHash {
 public:
  ContentHash();
  ~ContentHash();
  ContentHash(const ContentHash&) = delete;
  ContentHash& operator=(const ContentHash&) = delete;

  void update(const void* data, std::size_t byte_count);
  void update(std::string_view text) { update(text.data(), text.size()); }
  /// Returns 64 lower-case hexadecimal digits. Call it only once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string hash_text(std::string_view text);
/// Returns the SHA-256 of a file, or of an image in memory that is given by its name
/// (host/foundation/base/files/memory_images.h). Throws Error(kInput) if the file cannot be read.
std::string hash_file(const std::string& path);

}  // namespace multum
