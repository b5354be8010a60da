// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using std::chrono::milliseconds;

constexpr const char* kBatchPrefix = "batch-";
constexpr std::size_t kLogBytesAtOnce = 1 << 20;

std::string order_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// Returns nullopt if the file is missing or incomplete.
std::optional<Json> read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  Json json = Json::parse(file, nullptr, false);
  return json.is_object() ? std::optional(std::move(json)) : std::nullopt;
}

// Also returns nullopt for values of wrong types.
template <typename Value, typename Read>
std::optional<Value> read_as(const std::string& path, const Read& read) {
  try {
    if (const std::optional<Json> json = read_json(path)) return read(*json);
  } catch (const Json::exception&) {
  }
  return std::nullopt;
}

void append_to(const std::string& path, const std::string& text) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file < 0) fail_by_errno(path, "cannot be written");
  const ssize_t written = ::write(file, text.data(), text.size());
  ::close(file);
  if (written != static_cast<ssize_t>(text.size())) fail_by_errno(path, "cannot be written");
}

}  // namespace

void SlurmBatchFolder::write_order(const SlurmOrder& order) const {
  make_folder(path_);
  Json items = Json::array();
  for (const SlurmOrder::Item& item : order.items) {
    items.push_back(work_json(item.work));
    items.back()["item"] = item.number;
  }
  write_text_file(path_ + "/order.json", order_text({{"is_array", order.is_array},
                                                     {"roots", texts_of_paths(order.roots)},
                                                     {"threads", order.threads},
                                                     {"lease_ms", order.lease.count()},
                                                     {"no_progress_ms", order.no_progress.count()},
                                                     {"cancel_grace_ms", order.cancel_grace.count()},
                                                     {"items", items}}));
}

bool SlurmBatchFolder::has_order() const {
  return ::access((path_ + "/order.json").c_str(), F_OK) == 0 || errno != ENOENT;
}

SlurmOrder SlurmBatchFolder::read_order() const {
  const std::optional<Json> json = read_json(path_ + "/order.json");
  if (!json)
    throw Error(ErrorCode::kEnvironment, path_ + "/order.json: is missing: the daemon has withdrawn the order");
  try {
    SlurmOrder order;
    order.is_array = json->at("is_array");
    order.roots = paths_of_texts(json->at("roots").get<std::vector<std::string>>());
    order.threads = json->at("threads");
    order.lease = milliseconds(json->at("lease_ms").get<std::int64_t>());
    order.no_progress = milliseconds(json->at("no_progress_ms").get<std::int64_t>());
    order.cancel_grace = milliseconds(json->at("cancel_grace_ms").get<std::int64_t>());
    for (const Json& item : json->at("items")) order.items.push_back({item.at("item"), work_from(item)});
    return order;
  } catch (const Json::exception& error) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}/order.json: is not an order of multum {}: {}; the daemon will send its jobs again",
                            path_, MULTUM_VERSION, error.what()));
  }
}

void SlurmBatchFolder::revoke_order() const { ::unlink((path_ + "/order.json").c_str()); }

void SlurmBatchFolder::stop(int item) const { write_text_file(fmt::format("{}/stop-{}", path_, item), ""); }
bool SlurmBatchFolder::is_stopped(int item) const {
  return ::access(fmt::format("{}/stop-{}", path_, item).c_str(), F_OK) == 0;
}

std::set<std::string> SlurmBatchFolder::names() const {
  std::set<std::string> found;
  std::error_code failed;
  for (fs::directory_iterator entry(path_, failed), end; !failed && entry != end; entry.increment(failed))
    found.insert(entry->path().filename().string());
  return found;
}

std::string SlurmBatchFolder::status_name(int item) { return fmt::format("status-{}.json", item); }
std::string SlurmBatchFolder::end_name(int item) { return fmt::format("ended-{}.json", item); }
std::string SlurmBatchFolder::output_name(int item, bool is_array) {
  return is_array ? fmt::format("slurm-{}.out", item) : "slurm.out";
}

void SlurmBatchFolder::write_status(int item, const SlurmStatus& status) const {
  write_text_file(path_ + "/" + status_name(item), order_text({{"beat", status.beat},
                                                               {"node", status.node},
                                                               {"stage", status.progress.stage},
                                                               {"done", status.progress.done},
                                                               {"total", status.progress.total}}));
}

void SlurmBatchFolder::write_end(int item, const SlurmEnd& end) const {
  write_text_file(path_ + "/" + end_name(item), order_text({{"exit_code", end.result.exit_code},
                                                            {"message", text_of_message(end.result.message)},
                                                            {"inputs_changed", end.result.have_inputs_changed},
                                                            {"node", end.node}}));
}

std::optional<SlurmStatus> SlurmBatchFolder::status(int item) const {
  return read_as<SlurmStatus>(path_ + "/" + status_name(item), [](const Json& json) {
    return SlurmStatus{
        json.value("beat", std::uint64_t{0}),
        json.value("node", ""),
        {json.value("stage", ""), json.value("done", std::uint64_t{0}), json.value("total", std::uint64_t{0})}};
  });
}

std::optional<SlurmEnd> SlurmBatchFolder::end(int item) const {
  return read_as<SlurmEnd>(path_ + "/" + end_name(item), [](const Json& json) {
    return SlurmEnd{{json.value("exit_code", 4), json.value("message", ""), json.value("inputs_changed", true)},
                    json.value("node", "")};
  });
}

std::string SlurmBatchFolder::make_work_folder(int item) const {
  const std::string folder = fmt::format("{}/work-{}", path_, item);
  // The folders of a daemon's data. Slurm workers do not use the last two.
  for (const char* part : {"logs", "scratch", "uploads", "results"}) make_folder(folder + "/" + part);
  return folder;
}

std::string SlurmBatchFolder::log(int work_item, int item) const {
  return fmt::format("{}/work-{}/logs/{}.log", path_, work_item, item);
}

std::string SlurmBatchFolder::output(bool is_array) const {
  return path_ + (is_array ? "/slurm-%a.out" : "/slurm.out");
}

std::string SlurmBatchFolder::last_words(int item, bool is_array) const {
  std::ifstream file(path_ + "/" + output_name(item, is_array));
  std::string line, last;
  while (std::getline(file, line))
    if (!line.empty()) last = line.substr(0, 500);
  return last;
}

void SlurmBatchFolder::move_log(int work_item, int item, const std::string& to, const std::string& prefix,
                                bool is_last) const {
  // A file next to the log records how many bytes have been moved, so that the next daemon knows this too. No link is
  // followed, because workers write to this folder.
  const std::string noted = fmt::format("{}/moved-{}", path_, item);
  std::int64_t begin = 0;
  std::ifstream(noted) >> begin;
  const OpenFile folder(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const OpenFile file = open_beneath_folder(folder, fmt::format("work-{}/logs/{}.log", work_item, item),
                                            O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (!folder.is_open() || !file.is_open()) return;
  std::string text(kLogBytesAtOnce, '\0');
  const ssize_t count = ::pread(file.descriptor(), text.data(), text.size(), begin);
  if (count <= 0) return;
  text.resize(static_cast<std::size_t>(count));
  const std::size_t whole = text.rfind('\n') + 1;
  if (!is_last && text.size() < kLogBytesAtOnce) text.resize(whole);
  if (text.empty()) return;
  std::string lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines += prefix + line + "\n";
  append_to(to, lines);
  write_text_file(noted, fmt::format("{}\n", begin + static_cast<std::int64_t>(text.size())));
}

SlurmFolder::SlurmFolder(const std::string& folder, const std::string& instance)
    : path_(folder + "/multum-" + instance) {}

void SlurmFolder::prepare() const {
  make_folder(path_);
  // Slurm accepts only scripts. This script runs the words that follow it.
  if (!fs::exists(script())) write_text_file(script(), "#!/bin/sh\nexec \"$@\"\n");
}

SlurmBatchFolder SlurmFolder::batch(std::int64_t number) const {
  return SlurmBatchFolder(fmt::format("{}/{}{}", path_, kBatchPrefix, number));
}

void SlurmFolder::remove(std::int64_t number) const {
  std::error_code ignored;
  fs::remove_all(batch(number).path(), ignored);
}

std::vector<std::int64_t> SlurmFolder::batches() const {
  std::vector<std::int64_t> numbers;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path_, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kBatchPrefix)) continue;
    std::int64_t number = 0;
    const char* end = name.data() + name.size();
    const auto [stop, failed] = std::from_chars(name.data() + std::string(kBatchPrefix).size(), end, number);
    if (failed == std::errc() && stop == end) numbers.push_back(number);
  }
  return numbers;
}

}  // namespace multum
