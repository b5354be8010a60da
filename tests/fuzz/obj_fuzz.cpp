// SPDX-License-Identifier: Apache-2.0
// Fuzzes the OBJ mesh readers of multum-decode, which read the whole mesh or single objects.
#include "tests/fuzz/mesh_checks.h"

namespace multum {
namespace {

constexpr char kObj[] =
    "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\ng more\nusemtl brick\nf 1/1 2/2 3/3\nf -1/-1 -2/-2 -3/-3\n";

}  // namespace

std::vector<std::string> fuzz::seeds() { return {std::string(1, '\0') + kObj, std::string(1, '\1') + kObj}; }

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 2);
  const std::string path = fuzz::input_file("input.obj", input.bytes);
  fuzz::may_refuse([&] { input.kind == 0 ? fuzz::read_whole(path) : fuzz::read_objects(path); });
  return 0;
}
