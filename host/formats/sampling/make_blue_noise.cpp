// SPDX-License-Identifier: Apache-2.0
// make_blue_noise FILE writes the texture of blue_noise.h as C++ source code. The build runs this program.
#include <cstdio>
#include <fstream>

#include "host/formats/sampling/blue_noise.h"
#include "host/formats/sampling/void_and_cluster.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "make_blue_noise: expected one argument, the file to write\n");
    return 2;
  }
  std::vector<std::vector<int>> masks;
  for (std::uint32_t seed = 1; seed <= 4; ++seed)
    masks.push_back(multum::void_and_cluster(multum::kBlueNoiseSide, seed));
  const std::size_t count = masks.front().size();
  std::ofstream file(argv[1]);
  file << "// Made by make_blue_noise.\n#include \"host/formats/sampling/blue_noise.h\"\n\nnamespace multum "
          "{\nnamespace {\n\n"
          "constexpr std::uint8_t kTexels[] = {\n";
  for (std::size_t i = 0; i < count; ++i) {
    for (const std::vector<int>& mask : masks) file << static_cast<std::size_t>(mask[i]) * 256 / count << ',';
    file << '\n';
  }
  file << "};\n\n}  // namespace\n\nstd::span<const std::uint8_t> blue_noise() { return kTexels; }\n\n"
          "}  // namespace multum\n";
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "make_blue_noise: %s: cannot be written\n", argv[1]);
  return 3;
}
