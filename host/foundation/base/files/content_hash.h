// SPDX-License-Identifier: Apache-2.0
// SHA-256, so that what a header states can be checked with sha256sum.
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
  /// 64 lower-case hexadecimal digits. Called once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string hash_text(std::string_view text);
/// Throws Error(kInput) when the file cannot be read.
std::string hash_file(const std::string& path);

}  // namespace multum
