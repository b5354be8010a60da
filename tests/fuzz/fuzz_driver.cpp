// SPDX-License-Identifier: Apache-2.0
// Runs a fuzzer without libFuzzer, with any compiler, on its seeds, on inputs of fixed findings, and on mutations of
// both. The mutations depend only on a printed seed. Coverage does not guide this run; it guides tools/fuzz.
//   fuzz_NAME FOLDER_OF_FINDINGS [SECONDS] [SEED]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "host/foundation/base/split_mix.h"
#include "tests/fuzz/fuzz.h"

namespace multum::fuzz {
namespace {

namespace fs = std::filesystem;

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  std::string mutate(std::string input) {
    for (std::size_t left = 1 + below(4); left > 0; --left) step(input);
    return input;
  }
  std::size_t below(std::size_t count) { return count == 0 ? 0 : static_cast<std::size_t>(random_.next() % count); }

 private:
  void step(std::string& input) {
    constexpr std::size_t kSizeMax = 1 << 16;
    const std::size_t at = below(input.size());
    switch (below(6)) {
      case 0: input.resize(at); break;  // cuts the input
      case 1:                           // flips a bit
        if (!input.empty()) input[at] = static_cast<char>(input[at] ^ (1 << below(8)));
        break;
      case 2: absurd_number(input, at); break;
      case 3: input.erase(at, below(64)); break;
      case 4: {  // an attribute bomb, which repeats one piece many times
        const std::string piece = input.substr(at, 1 + below(128));
        for (std::size_t left = below(100); left > 0 && input.size() < kSizeMax; --left) input.insert(at, piece);
        break;
      }
      default: {  // copies a piece from another place
        const std::string piece = input.substr(below(input.size()), 1 + below(32));
        input.replace(at, std::min(piece.size(), input.size() - at), piece);
      }
    }
  }

  void absurd_number(std::string& input, std::size_t at) {
    constexpr std::uint64_t kNumbers[] = {0,      1,          0x7f,       0x80,       0xff,       0x7fff,
                                          0xffff, 0x7fffffff, 0x80000000, 0xffffffff, 0x40000000, 0x7fffffffffffffff,
                                          ~0ull,  0x7f800000, 0x7fc00000, 1ull << 62};
    std::uint64_t number = kNumbers[below(std::size(kNumbers))];
    if (below(2) == 0) number = __builtin_bswap64(number) >> (below(2) * 32);
    const std::size_t width = std::min<std::size_t>(std::size_t{1} << below(4), input.size() - at);
    std::memcpy(input.data() + at, &number, width);
  }

  SplitMix64 random_;
};

void try_input(const std::string& input) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

int drive(const std::string& findings, double seconds, std::uint64_t seed) {
  std::vector<std::string> inputs = seeds();
  const std::size_t seed_count = inputs.size();
  if (fs::is_directory(findings))
    for (const fs::directory_entry& entry : fs::directory_iterator(findings))
      inputs.push_back(file_bytes(entry.path().string()));
  std::sort(inputs.begin() + static_cast<std::ptrdiff_t>(seed_count), inputs.end());
  try_input("");
  std::size_t refused_seeds = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::uint64_t before = refused_count;
    try_input(inputs[i]);
    if (i < seed_count && refused_count > before) ++refused_seeds;
  }
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  Mutator mutator(seed);
  std::uint64_t count = 0;
  for (; std::chrono::duration<double>(Clock::now() - start).count() < seconds; ++count)
    try_input(mutator.mutate(inputs[mutator.below(inputs.size())]));
  std::printf("%zu seeds (%zu of them refused), %zu earlier findings, %llu mutations with seed %llu: no crash\n",
              seed_count, refused_seeds, inputs.size() - seed_count, static_cast<unsigned long long>(count),
              static_cast<unsigned long long>(seed));
  return inputs.empty() ? 1 : 0;
}

}  // namespace
}  // namespace multum::fuzz

int main(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fputs("expected FOLDER_OF_FINDINGS [SECONDS] [SEED]\n", stderr);
    return 2;
  }
  return multum::fuzz::drive(argv[1], argc > 2 ? std::atof(argv[2]) : 1.0,
                             argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
}
