// SPDX-License-Identifier: Apache-2.0
// make_ggx_lobe_table FILE writes the fitted table of ggx_lobe.h as C++ source code. The build runs this program.
#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <numbers>

#include "host/formats/brdf/ggx_lobe_fit.h"
#include "host/foundation/base/half_bits.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "make_ggx_lobe_table: expected one argument, the file to write\n");
    return 2;
  }
  std::ofstream file(argv[1]);
  file << "// Made by make_ggx_lobe_table.\n#include \"host/formats/brdf/ggx_lobe.h\"\n\nnamespace multum {\nnamespace "
          "{\n\n"
          "constexpr std::uint16_t kTable[] = {\n";
  for (const multum::GgxLobeShape& shape : multum::fit_ggx_lobe_table()) {
    for (const double value : {shape.peak / std::numbers::pi, shape.slope, shape.bend, -shape.power})
      file << fmt::format("{},", multum::float_to_half(static_cast<float>(value)));
    file << '\n';
  }
  file << "};\n\n}  // namespace\n\nstd::span<const std::uint16_t> ggx_lobe_table() { return kTable; }\n\n"
          "}  // namespace multum\n";
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "make_ggx_lobe_table: %s: cannot be written\n", argv[1]);
  return 3;
}
