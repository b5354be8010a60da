// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/decoding_child.h"

#include <filesystem>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/process_rules/process_rules.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

// Keeps a child process so that it can decode the next file.
class IdleChildren {
 public:
  std::unique_ptr<HelperProcess> take(const std::string& program) {
    const std::lock_guard lock(mutex_);
    if (idle_ != nullptr && idle_->program() == program) return std::move(idle_);
    return std::make_unique<HelperProcess>(program);
  }
  void give_back(std::unique_ptr<HelperProcess> child) {
    const std::lock_guard lock(mutex_);
    idle_ = std::move(child);
  }

 private:
  std::mutex mutex_;
  std::unique_ptr<HelperProcess> idle_;
};

IdleChildren& idle_children() {
  static IdleChildren children;
  return children;
}

}  // namespace

std::string decoder_beside_this_program() {
  const std::filesystem::path folder = program_folder(), name = "multum-decode";
  const std::filesystem::path installed = folder.parent_path() / "libexec" / "multum" / name;
  std::error_code error;
  return (!std::filesystem::exists(folder / name, error) && std::filesystem::exists(installed, error) ? installed
                                                                                                      : folder / name)
      .string();
}

DecodedFile::DecodedFile(DecodingChild child, std::string path, std::string library)
    : child_(std::move(child)),
      path_(std::move(path)),
      library_(std::move(library)),
      process_(idle_children().take(child_.program)) {
  allow(0, {});
}

// A child that answers "close" can decode the next file.
DecodedFile::~DecodedFile() {
  if (!process_->is_alive()) return;
  try {
    const std::string request = MessageWriter().number(DecodingRequest::kClose).take();
    ask(request, [](MessageReader&) { return true; });
    idle_children().give_back(std::move(process_));
  } catch (const std::exception&) {  // the child is killed
  }
}

void DecodedFile::allow(std::uint64_t more_memory, std::chrono::seconds more_time) {
  limits_ = {child_.memory_base + more_memory, std::chrono::milliseconds(child_.time_base_ms) + more_time};
}

std::string DecodedFile::answer(const std::string& request, const std::function<void()>& while_waiting) {
  try {
    return process_->ask(request, limits_, while_waiting);
  } catch (const HelperEnded& ended) {
    if (ended.lacked_memory())
      throw Error(ErrorCode::kEnvironment,
                  fmt::format("{}: decoding failed (the decoder {}), probably for lack of memory; expected {} bytes of "
                              "memory. Use a machine, a container or limits (ulimit -v) that allow this",
                              path_, ended.what(), limits_.memory_max));
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: decoding failed (the decoder {}); expected an undamaged file that {} can decode within {} "
                    "bytes of memory and {} s",
                    path_, ended.what(), library_, limits_.memory_max,
                    std::chrono::duration<double>(limits_.time_max).count()));
  }
}

}  // namespace multum
