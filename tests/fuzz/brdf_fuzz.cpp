// SPDX-License-Identifier: Apache-2.0
// Fuzzes the readers of measured BRDFs: tables by wavelength, MERL's binary files, and networks as JSON. The results
// must be finite.
#include <cmath>

#include "host/formats/brdf/measured_file.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

constexpr const char* kNames[] = {"input.brdf", "input.binary", "input.json"};

std::string table() {
  std::string text = "3\n400 550 700\n";
  for (int i = 0; i < 40; ++i)
    text += std::to_string(0.03 * i) + " 0 " + std::to_string(0.03 * (40 - i)) + " 3.1 " +
            std::to_string(0.2 + 0.01 * i) + " 0.3 0.1\n";
  return text;
}

constexpr char kNetwork[] =
    R"({"layers":[{"kernel":[[0],[0],[1],[0],[0],[0]],"bias":[0]},{"kernel":[[4,4,2]],"bias":[-2,-2,-1]}]})";

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::int32_t sizes[3] = {90, 90, 180};
  const std::string merl(reinterpret_cast<const char*>(sizes), sizeof(sizes));
  return {std::string(1, '\0') + table(), "\1" + merl + std::string(64, '\0'), std::string("\2") + kNetwork};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 3);
  const std::string path = fuzz::input_file(kNames[input.kind], input.bytes);
  fuzz::may_refuse([&] {
    const MeasuredBrdf brdf = read_measured_brdf(path);
    for (int channel = 0; channel < 3; ++channel) MULTUM_CHECK(std::isfinite(brdf.diffuse[channel]));
    const auto facets = measured_facets(brdf, 0.1);
    MULTUM_CHECK(std::isfinite(facets.x) && std::isfinite(facets.y) && std::isfinite(facets.z));
  });
  return 0;
}
