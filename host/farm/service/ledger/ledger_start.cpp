// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/ledger_start.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "host/farm/service/files/job_numbers.h"
#include "host/farm/service/ledger/ledger_schema.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

bool has_bytes(const std::string& path) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path, error);
  return !error && bytes > 0;
}

}  // namespace

std::string read_instance(const std::string& data) {
  std::ifstream file(data + "/instance");
  std::string name;
  return std::getline(file, name) && name.size() == 8 ? name : "";
}

LedgerSettings find_ledger(const std::string& data, RetryPolicy retry, bool begins_anew) {
  LedgerSettings settings;
  settings.path = data + "/jobs.sqlite";
  settings.results = fs::weakly_canonical(data + "/results").string();
  settings.instance = read_instance(data);
  settings.numbers = data + "/numbers";
  settings.retry = retry;
  std::error_code error;
  const bool was_used = fs::exists(data + "/instance", error);
  if (begins_anew) {
    for (const char* part : {"", "-wal", "-journal"})
      if (has_bytes(settings.path + part))
        throw Error(ErrorCode::kUsage,
                    fmt::format("--new-ledger: {}{} exists, and its jobs would be lost; move it away first, or start "
                                "without --new-ledger",
                                settings.path, part));
  } else if (was_used && !has_bytes(settings.path)) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: is {}, and {} was used before: {}", settings.path,
                            fs::exists(settings.path, error) ? "empty" : "missing", data, lost_ledger_advice()));
  }
  settings.may_begin = begins_anew || settings.instance.empty();  // the file may be unreadable, and the ledger also
                                                                  // stores the name
  if (settings.instance.empty()) {
    std::random_device random;
    settings.instance = fmt::format("{:08x}", random());
  }
  return settings;
}

std::string take_up_ledger(QueueThread& ledger, const std::string& data) {
  std::string instance;
  const std::int64_t highest = highest_job_number(data);
  ledger.run_now([&](JobQueue& queue) {
    queue.number_above(highest);
    instance = queue.instance();
  });
  // The name is written last, because a start that is interrupted before has used no numbers.
  if (read_instance(data) != instance) write_text_file(data + "/instance", instance + "\n");
  return instance;
}

}  // namespace multum
