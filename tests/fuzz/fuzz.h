// SPDX-License-Identifier: Apache-2.0
// Contains the shared parts of all fuzzers. A fuzzer is a file NAME_fuzz.cpp with the two functions below. The first is
// the entry point of libFuzzer; fuzz_driver.cpp also calls it, in a short deterministic run for the tests. If there are
// several readers, the first byte of an input chooses one. A reader may refuse its input with an Error; any other
// exception is a finding.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/foundation/base/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace multum::fuzz {

/// Returns valid inputs that the project's own writers made. The mutations start from these inputs. The first byte
/// chooses the reader.
std::vector<std::string> seeds();

/// Writes the input to a file, which has the same path each time and is in memory if possible. `name` is, for example,
/// "input.gltf".
std::string input_file(const char* name, std::string_view bytes);
/// Returns the contents of a file that the writer of a seed has made.
std::string file_bytes(const std::string& path);
/// Returns the process's temporary folder, which is removed with the process.
const std::string& scratch_folder();

/// Holds the number of the chosen reader (out of `count`) and the rest of the input. An empty input chooses the first
/// reader.
struct Input {
  unsigned kind;
  std::string_view bytes;
};
Input split(const std::uint8_t* data, std::size_t size, unsigned count);

/// The number of calls of may_refuse() in which `body` refused its input.
inline std::uint64_t refused_count = 0;

template <typename Body>
void may_refuse(const Body& body) {
  try {
    body();
  } catch (const Error&) {  // the only accepted kind of exception
    ++refused_count;
  }
}

}  // namespace multum::fuzz
