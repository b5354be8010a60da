// SPDX-License-Identifier: Apache-2.0
// A child process that fails in the way that its requests specify. If it replaces multum-decode, the name of the file
// to open specifies how it fails.
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "host/foundation/sandbox/damaged_file.h"
#include "host/foundation/sandbox/decoding_answer.h"
#include "host/foundation/sandbox/helper_service.h"

namespace multum {
namespace {

std::string fail_as_told(std::string_view told) {
  const auto is = [&](std::string_view what) { return told.find(what) != std::string_view::npos; };
  if (is("abort")) {
    std::fputs("a library's last words\n", stderr);
    std::abort();
  }
  if (is("segfault")) std::raise(SIGSEGV);
  if (is("exit")) std::_Exit(7);
  if (is("unloaded")) std::_Exit(127);  // like ld.so
  if (is("kill")) std::raise(SIGKILL);  // like the system when memory runs out
  if (is("hungry")) return answer_or_refusal([]() -> std::string { throw NotEnoughMemory("a.png"); });
  if (is("words"))
    return answer_or_refusal(
        []() -> std::string { throw Error(ErrorCode::kInput, "a.tif: damaged: Insufficient memory (case 4)"); });
  if (is("hang"))
    for (;;) ::pause();
  if (is("spin"))
    for (std::atomic<unsigned> i = 0;; ++i) {
    }
  if (is("nap")) {
    ::usleep(100000);
    return "done";
  }
  if (is("thread")) {
    std::thread([] { fail_as_told("work"); }).join();
    return "done";
  }
  if (is("work")) {  // uses a tenth of a second of processor time
    for (timespec used = {}; used.tv_sec == 0 && used.tv_nsec < 100000000;)
      ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return "done";
  }
  if (is("eat"))  // up to its limit: allocation fails, or the process is killed
    for (std::vector<char*> pieces;;) {
      constexpr std::size_t kPiece = std::size_t{8} << 20;
      pieces.push_back(static_cast<char*>(std::malloc(kPiece)));
      if (pieces.back() == nullptr) return "full";
      std::memset(pieces.back(), 1, kPiece);
    }
  if (is("announce")) {
    const std::uint64_t size = ~std::uint64_t{0};
    ::send(kHelperSocket, &size, sizeof(size), 0);
    for (;;) ::pause();
  }
  if (is("chatter")) {
    const std::string more(100, '\0');
    ::send(kHelperSocket, more.data(), more.size(), 0);
    for (;;) ::pause();
  }
  if (is("limits")) {
    rlimit core = {}, processor = {};
    ::getrlimit(RLIMIT_CORE, &core);
    ::getrlimit(RLIMIT_CPU, &processor);
    return std::to_string(core.rlim_cur) + " " + std::to_string(processor.rlim_cur);
  }
  if (is("files")) {
    std::string open;
    for (int descriptor = 0; descriptor < 64; ++descriptor)
      if (::lseek(descriptor, 0, SEEK_CUR) >= 0 || errno != EBADF) open += std::to_string(descriptor) + " ";
    return open;
  }
  return "nonsense";
}

}  // namespace
}  // namespace multum

int main() {
  using namespace multum;
  return serve_helper([](std::string_view request, SharedMemory& memory) {
    std::size_t byte_count = 0;
    if (request.starts_with("write")) std::memset(memory.see(byte_count), 42, 1);
    return fail_as_told(request);
  });
}
