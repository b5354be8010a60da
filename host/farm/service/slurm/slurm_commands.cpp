// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/slurm/slurm_commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <sstream>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr auto kCommandTimeMax = std::chrono::seconds(60);  // time limit of a command; Slurm's own timeouts are shorter
constexpr std::size_t kNamesAtOnce = 500;                   // names per call of scancel

template <typename Number>
std::optional<Number> whole_number(const std::string& text) {
  Number value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end && !text.empty() ? std::optional(value) : std::nullopt;
}

// Joins the lines of a command's output.
std::string in_one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at)) text.replace(at, 1, "; ");
  return text.empty() ? "no message" : text;
}

// The error texts of Slurm 22.05 (src/common/slurm_errno.c), in lower case. After these errors, Slurm accepts the same
// order when the controller answers again, or when the partition is up again.
constexpr std::array kNotNowTexts = {"unable to contact slurm controller",
                                     "timed out",
                                     "did not end within",
                                     "temporarily",
                                     "try again",
                                     "not available now",
                                     "not usable now",
                                     "standby mode",
                                     "connection failure",
                                     "send failure",
                                     "receive failure",
                                     "shutdown failure",
                                     "connection refused",
                                     "failed to send entire message",
                                     "zero length message",
                                     "zero bytes were transmitted",
                                     "failed to connect to authentication agent",
                                     "could not establish a configuration source",
                                     "inactive or drain",
                                     "partition in down state",
                                     "submissions disabled",
                                     "requested nodes are busy",
                                     "credential"};
// After these errors, the settings name something that does not exist, or that this user may not use.
constexpr std::array kNeverTexts = {"invalid",
                                    "unrecognized option",
                                    "option requires",
                                    "no partition specified",
                                    "permission denied",
                                    "access denied",
                                    "not permitted",
                                    "nodes not in this partition",
                                    "than permitted",
                                    "node configuration is not available",
                                    "memory required by task is not available",
                                    "can not be satisfied",
                                    "more tasks than available",
                                    "more ports than can be",
                                    "not supported",
                                    "specification required",
                                    "too long",
                                    "user not found"};

}  // namespace

SlurmRefusal refusal_of(const std::string& said) {
  std::string text = said;
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto has_one = [&](const auto& texts) {
    return std::any_of(texts.begin(), texts.end(),
                       [&](const char* one) { return text.find(one) != std::string::npos; });
  };
  if (has_one(kNotNowTexts)) return SlurmRefusal::kNotNow;
  if (text.find("invalid job array specification") != std::string::npos) return SlurmRefusal::kArrayTooLong;
  return has_one(kNeverTexts) ? SlurmRefusal::kNever : SlurmRefusal::kUnknown;
}

bool SlurmTask::is_over() const {
  static constexpr std::array kOver = {"BOOT_FAIL", "CANCELLED",     "COMPLETED", "DEADLINE", "FAILED",
                                       "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED",  "TIMEOUT"};
  return std::find(kOver.begin(), kOver.end(), state) != kOver.end();
}

bool SlurmTask::is_stuck() const {
  // Slurm holds a task if a node cannot start it, or if a dependency has become impossible. Tasks that users hold only
  // wait.
  return state == "PENDING" && (reason == "launch_failed_requeued_held" || reason == "launch failed requeued held" ||
                                reason == "DependencyNeverSatisfied");
}

std::string slurm_task_name(std::int64_t job, int item) {
  return item < 0 ? fmt::format("{}", job) : fmt::format("{}_{}", job, item);
}

SlurmCommands::SlurmCommands(SlurmSettings settings, std::function<bool()> is_stopped)
    : settings_(std::move(settings)), is_stopped_(std::move(is_stopped)) {}

ChildResult SlurmCommands::run_to_end(const std::vector<std::string>& words) const {
  ChildLimits limits;
  limits.time_max = kCommandTimeMax;
  limits.is_cancelled = is_stopped_;
  const ChildResult done = run_child(words, limits);
  if (done.is_over_time)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{} did not end within {} s", words.front(), kCommandTimeMax.count()));
  return done;
}

std::string SlurmCommands::run(const std::vector<std::string>& words) const {
  const ChildResult done = run_to_end(words);
  if (done.exit_code != 0)
    throw Error(ErrorCode::kEnvironment, fmt::format("{}: {}", words.front(), in_one_line(done.output)));
  return done.output;
}

std::int64_t SlurmCommands::submit(const SlurmSubmission& s) const {
  std::vector<std::string> words = {"sbatch",
                                    "--parsable",
                                    "--requeue",
                                    "--job-name=" + s.name,
                                    "--comment=" + s.comment,
                                    "--output=" + s.output,
                                    "--open-mode=append",
                                    "--chdir=/",
                                    "--nodes=1",
                                    "--ntasks=1",
                                    fmt::format("--cpus-per-task={}", settings_.cpus)};
  if (!settings_.partition.empty()) words.push_back("--partition=" + settings_.partition);
  if (!settings_.account.empty()) words.push_back("--account=" + settings_.account);
  if (!s.array.empty()) words.push_back(fmt::format("--array={}", fmt::join(s.array, ",")));
  if (!s.after.empty()) words.push_back(fmt::format("--dependency=afterany:{}", fmt::join(s.after, ":")));
  if (s.memory_bytes > 0) words.push_back(fmt::format("--mem={}", (s.memory_bytes + (1 << 20) - 1) >> 20));  // in MiB
  if (s.nice > 0) words.push_back(fmt::format("--nice={}", s.nice));
  if (s.time_max.count() > 0) words.push_back(fmt::format("--time={}", (s.time_max.count() + 59) / 60));  // in minutes
  words.insert(words.end(), settings_.arguments.begin(), settings_.arguments.end());
  words.push_back(s.script);
  words.insert(words.end(), s.command.begin(), s.command.end());
  // sbatch prints "12" or "12;cluster", possibly after other lines.
  std::istringstream lines(run(words));
  std::string line, last;
  while (std::getline(lines, line))
    if (!line.empty()) last = line;
  const std::optional<std::int64_t> job = whole_number<std::int64_t>(last.substr(0, last.find(';')));
  if (!job) throw Error(ErrorCode::kEnvironment, fmt::format("sbatch printed '{}', expected a job number", last));
  return *job;
}

std::optional<int> SlurmCommands::array_size_max() const {
  try {
    return parse_array_size_max(run({"scontrol", "show", "config"}));
  } catch (const Error&) {  // scontrol is missing, or does not print the limit; sbatch will reject arrays that are too
                            // long
    return std::nullopt;
  }
}

std::optional<int> parse_array_size_max(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string name, equals, value;
    if (words >> name >> equals >> value && name == "MaxArraySize" && equals == "=") return whole_number<int>(value);
  }
  return std::nullopt;
}

std::vector<SlurmTask> SlurmCommands::list(const std::string& prefix) const {
  std::vector<SlurmTask> tasks = parse_squeue(
      run({"squeue", "--noheader", "--me", "--all", "--array", "--states=all", "--format=%F|%K|%T|%N|%j|%r"}));
  std::erase_if(tasks, [&](const SlurmTask& task) { return !task.name.starts_with(prefix); });
  return tasks;
}

std::vector<SlurmTask> parse_squeue(const std::string& text) {
  std::vector<SlurmTask> tasks;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::array<std::string, 6> parts;
    std::istringstream fields(line);
    std::size_t count = 0;
    while (count < parts.size() - 1 && std::getline(fields, parts[count], '|')) ++count;
    std::getline(fields, parts[count]);
    const std::optional<std::int64_t> job = whole_number<std::int64_t>(parts[0]);
    if (!job || count != parts.size() - 1) continue;
    tasks.push_back({*job, whole_number<int>(parts[1]).value_or(-1), parts[4], parts[2], parts[5], parts[3]});
  }
  return tasks;
}

void SlurmCommands::cancel(const std::vector<SlurmTarget>& targets) const {
  std::map<std::string, std::vector<std::string>> of_names;
  for (const SlurmTarget& target : targets) of_names[target.name].push_back(slurm_task_name(target.job, target.item));
  for (const auto& [name, tasks] : of_names)
    for (std::size_t begin = 0; begin < tasks.size(); begin += kNamesAtOnce) {
      std::vector<std::string> words = {"scancel", "--quiet", "--name=" + name};
      const auto first = tasks.begin() + static_cast<std::ptrdiff_t>(begin);
      words.insert(words.end(), first,
                   first + static_cast<std::ptrdiff_t>(std::min(kNamesAtOnce, tasks.size() - begin)));
      // For an unknown number, scancel prints nothing and exits with code 1.
      const ChildResult done = run_to_end(words);
      if (done.exit_code != 0 && !done.output.empty())
        throw Error(ErrorCode::kEnvironment, "scancel: " + in_one_line(done.output));
    }
}

}  // namespace multum
