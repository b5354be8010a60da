// SPDX-License-Identifier: Apache-2.0
// PoCL compiles kernels with a library of built-in functions for the processor's instruction set. Kernels must give the
// same bytes with every library, because a build farm has machines of several kinds.
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/cli/program.h"

namespace multum::testing {
namespace {

class KernelLibraryTest : public CliTest {
 protected:
  // Returns the content hash of a bake, or "" if PoCL lacks the library or the processor lacks the instructions.
  std::string hash_with(const std::string& library, const std::string& processor) {
    // PoCL caches the kernels of each processor separately.
    std::vector<std::string> command = {"env", "POCL_KERNELLIB_NAME=" + library, "POCL_LLVM_CPU_NAME=" + processor};
    for (const std::string& word :
         multum_command({"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o",
                         path(library + ".ndf.exr"), "--quiet", "--no-measure", "--no-start-search"}))
      command.push_back(word);
    const ProgramResult result = run_program(command);
    EXPECT_EQ(result.exit_code, 0) << library << ": " << result.err;
    return result.exit_code == 0 ? read_movmf_header(path(library + ".ndf.exr")).header.provenance.content_hash : "";
  }
};

TEST_F(KernelLibraryTest, Avx2AndAvx512GiveTheSameBytes) {
  const std::string flags = read_bytes("/proc/cpuinfo");
  const auto has = [&](const char* flag) { return flags.find(flag) != std::string::npos; };
  if (!has(" avx2 ") || !has(" fma ")) GTEST_SKIP() << "the processor has no AVX2";
  make_map("map", 128);
  const std::string avx2 = hash_with("avx2", "haswell");
  EXPECT_EQ(hash_with("sse2", "x86-64"), avx2);
  if (!has(" avx512f ") || !has(" avx512vl ")) GTEST_SKIP() << "the processor has no AVX-512: SSE2 and AVX2 agree";
  EXPECT_EQ(hash_with("avx512", "skylake-avx512"), avx2);
}

}  // namespace
}  // namespace multum::testing
