// SPDX-License-Identifier: Apache-2.0
// Shared parts of all fuzzers. A fuzzer is a file NAME_fuzz.cpp with the two functions below: the first is libFuzzer's,
// and is also called by fuzz_driver.cpp, a short deterministic run for the tests. An input that has several readers
// begins with a byte that chooses. A reader may refuse by Error; any other exception ends the fuzzer and is a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/foundation/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace multum::fuzz {

/// Inputs that are read to their end, made by the project's own writers: what mutation starts from. The first byte is
/// the reader's.
std::vector<std::string> seeds();

/// The input as a file in memory, where there is such a folder; the same path each time. `name`: as "input.gltf".
std::string input_file(const char* name, std::string_view bytes);
/// What is in a file that a seed's writer has made.
std::string file_bytes(const std::string& path);
/// Of the process; gone with it.
const std::string& scratch_folder();

/// Which of `count` readers, and the rest of the input. Empty input: the first one.
struct Input {
  unsigned kind;
  std::string_view bytes;
};
Input split(const std::uint8_t* data, std::size_t size, unsigned count);

template <typename Body>
void may_refuse(const Body& body) {
  try {
    body();
  } catch (const Error&) {  // the only way to say no
  }
}

}  // namespace multum::fuzz
