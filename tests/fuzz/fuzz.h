// SPDX-License-Identifier: Apache-2.0
// Shared parts of all fuzzers. A fuzzer is a file NAME_fuzz.cpp with the two functions below. The first is the entry
// point of libFuzzer; fuzz_driver.cpp also calls it, in a short deterministic run for the tests. If there are several
// readers, the first byte of an input chooses one. A reader may refuse its input with an Error; any other exception is
// a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/foundation/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace multum::fuzz {

/// Returns inputs that are read completely, made by the project's own writers, from which mutation starts. The first
/// byte chooses the reader.
std::vector<std::string> seeds();

/// Writes the input to a file, in memory if possible, with the same path each time. An example of `name` is
/// "input.gltf".
std::string input_file(const char* name, std::string_view bytes);
/// Returns the contents of a file that a seed's writer has made.
std::string file_bytes(const std::string& path);
/// Returns the process's temporary folder, which is removed with the process.
const std::string& scratch_folder();

/// Holds the chosen one of `count` readers, and the rest of the input. An empty input chooses the first reader.
struct Input {
  unsigned kind;
  std::string_view bytes;
};
Input split(const std::uint8_t* data, std::size_t size, unsigned count);

template <typename Body>
void may_refuse(const Body& body) {
  try {
    body();
  } catch (const Error&) {  // the only accepted kind of refusal
  }
}

}  // namespace multum::fuzz
