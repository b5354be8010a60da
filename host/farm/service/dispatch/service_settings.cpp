// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/dispatch/service_settings.h"

#include <fmt/format.h>

#include <sys/stat.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

const std::vector<std::string> kKeys = {
    "listen",     "token_file",     "roots",          "workers",          "threads_a_worker", "memory_max",
    "lease_s",    "no_progress_s",  "cancel_grace_s", "shutdown_grace_s", "back_off_first_s", "back_off_max_s",
    "upload_max", "retention_days", "data_max",       "upload_days",      "connections_max",  "request_memory_max",
    "queue",      "device",         "slurm"};

// Parses sizes such as "800M" or "2G", in the syntax of --memory.
std::optional<std::int64_t> parse_bytes(const std::string& text) {
  double value = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || !(value >= 0.0)) return std::nullopt;
  const std::string unit(stop, end);
  double factor = 0.0;
  if (unit.empty() || unit == "B") factor = 1.0;
  else if (unit == "K") factor = 1 << 10;
  else if (unit == "M") factor = 1 << 20;
  else if (unit == "G") factor = 1 << 30;
  else if (unit == "T") factor = std::ldexp(1.0, 40);
  if (factor == 0.0 || value * factor > 9e18) return std::nullopt;
  return static_cast<std::int64_t>(value * factor);
}

std::int64_t bytes(const StrictTable& table, const std::string& key, std::int64_t fallback) {
  if (!table.has(key)) return fallback;
  const std::string text = table.text(key);
  const std::optional<std::int64_t> found = parse_bytes(text);
  if (!found) table.refuse(key, fmt::format("is \"{}\", expected a size, e.g. \"800M\" or \"2G\"", text));
  return *found;
}

std::chrono::milliseconds seconds(const StrictTable& table, const std::string& key, std::chrono::milliseconds fallback,
                                  double least) {
  const NumberRange range = {least, 1e7, false, false, fmt::format("seconds from {:g} to 1e7", least)};
  const double value = table.number(key, range, static_cast<double>(fallback.count()) / 1000.0);
  return std::chrono::milliseconds(std::llround(1000.0 * value));
}

void read_queues(const StrictTable& root, const std::string& path, ServiceSettings& settings) {
  if (!root.has("queue")) return;
  settings.queues.clear();
  for (const toml::table* entry : root.tables("queue")) {
    const StrictTable table(path, *entry, "queue", {"name", "priority", "jobs", "memory_max", "paused"});
    QueueLimits limits;
    limits.priority = table.whole("priority", -1000, 1000, 0);
    limits.jobs_max = table.whole("jobs", 1, 1 << 30, limits.jobs_max);
    limits.memory_max = bytes(table, "memory_max", 0);
    limits.is_paused = table.boolean("paused", false);
    const std::string name = table.text("name");
    if (!settings.queues.emplace(name, limits).second)
      table.refuse("name", fmt::format("is \"{}\", which is the name of another queue", name));
  }
}

void read_devices(const StrictTable& root, const std::string& path, ServiceSettings& settings) {
  if (!root.has("device")) return;
  for (const toml::table* entry : root.tables("device")) {
    const StrictTable table(path, *entry, "device", {"name", "jobs"});
    settings.devices[table.text("name")] = table.whole("jobs", 1, 1024);
  }
}

const std::vector<std::string> kSlurmKeys = {"folder",     "partition", "account",   "arguments",   "program",
                                             "queues",     "types",     "jobs",      "cpus",        "nice",
                                             "chunk_s",    "share_s",   "rounds",    "time_factor", "time_min_s",
                                             "time_max_s", "poll_s",    "visible_s", "lease_s"};

void read_slurm(const StrictTable& root, const std::string& path, ServiceSettings& settings) {
  if (!root.has("slurm")) return;
  SlurmSettings& s = settings.slurm;
  s = {};
  const StrictTable table(path, root.table("slurm"), "slurm", kSlurmKeys, "the settings");
  s.folder = std::filesystem::absolute(table.text("folder")).lexically_normal().string();
  s.partition = table.text("partition", "");
  s.account = table.text("account", "");
  if (table.has("arguments")) s.arguments = table.texts("arguments", true);
  s.program = table.text("program", "");
  s.queues = table.texts("queues", true);
  for (const std::string& queue : s.queues)
    if (!settings.queues.contains(queue))
      table.refuse("queues", fmt::format("has \"{}\", expected names of [[queue]]", queue));
  if (table.has("types")) s.types = table.texts("types", true);
  for (const std::string& type : s.types) find_job_type(type);
  s.jobs_max = table.whole("jobs", 1, 100000, s.jobs_max);
  s.cpus = table.whole("cpus", 1, 1024, s.cpus);
  s.nice = table.whole("nice", 0, 1 << 30, s.nice);
  s.chunk_seconds = table.number("chunk_s", kFromZero, s.chunk_seconds);
  s.share_seconds = table.number("share_s", kFromZero, s.share_seconds);
  s.rounds = table.whole("rounds", 1, 100, s.rounds);
  s.time_factor = table.number("time_factor", {1.0, 1000.0, false, false, "a number from 1 to 1000"}, s.time_factor);
  const auto whole_seconds = [&](const char* key, std::chrono::seconds fallback) {
    return std::chrono::duration_cast<std::chrono::seconds>(seconds(table, key, fallback, 60.0));
  };
  s.time_min = whole_seconds("time_min_s", s.time_min);
  s.time_max = whole_seconds("time_max_s", s.time_max);
  if (s.time_max < s.time_min) table.refuse("time_max_s", "is less than time_min_s");
  s.poll = seconds(table, "poll_s", s.poll, 0.1);
  s.visible = seconds(table, "visible_s", s.visible, 0.0);
  s.lease = seconds(table, "lease_s", s.lease, 2.0);
}

}  // namespace

void read_service_settings(const std::string& path, ServiceSettings& s) {
  const toml::table file = parse_toml(path, "settings that docs/reference/service.md lists");
  const StrictTable root(path, file, "", kKeys, "the settings");
  s.listen = root.text("listen", s.listen);
  s.token_file = root.text("token_file", s.token_file);
  if (root.has("roots")) s.roots = root.texts("roots", true);
  s.workers = root.whole("workers", 1, 256, s.workers);
  s.threads_a_worker = root.whole("threads_a_worker", 0, 1024, s.threads_a_worker);
  s.memory_max = bytes(root, "memory_max", s.memory_max);
  s.lease = seconds(root, "lease_s", s.lease, 2.0);
  s.no_progress = seconds(root, "no_progress_s", s.no_progress, 0.0);
  s.cancel_grace = seconds(root, "cancel_grace_s", s.cancel_grace, 0.0);
  s.shutdown_grace = seconds(root, "shutdown_grace_s", s.shutdown_grace, 0.0);
  s.retry.back_off_first =
      seconds(root, "back_off_first_s", std::chrono::milliseconds(s.retry.back_off_first), 0.0).count();
  s.retry.back_off_max = seconds(root, "back_off_max_s", std::chrono::milliseconds(s.retry.back_off_max), 0.0).count();
  s.upload_bytes_max = static_cast<int>(std::min<std::int64_t>(bytes(root, "upload_max", s.upload_bytes_max), 1 << 30));
  s.retention_days = root.whole("retention_days", 0, 100000, s.retention_days);
  s.data_max = bytes(root, "data_max", s.data_max);
  s.upload_days = root.whole("upload_days", 0, 100000, s.upload_days);
  s.connections_max = root.whole("connections_max", 8, 65536, s.connections_max);
  s.request_memory_max = bytes(root, "request_memory_max", s.request_memory_max);
  if (s.request_memory_max < 8 << 20) root.refuse("request_memory_max", "is less than 8M");
  read_queues(root, path, s);
  read_devices(root, path, s);
  read_slurm(root, path, s);
}

ListenAddress parse_listen_address(const std::string& text) {
  ListenAddress address;
  if (text.starts_with("unix:")) {
    address.unix_path = text.substr(5);
    if (address.unix_path.empty() || address.unix_path.size() > 107)
      throw Error(ErrorCode::kUsage, fmt::format("'{}': expected unix: followed by a path of up to 107 bytes", text));
    return address;
  }
  const std::size_t colon = text.rfind(':');
  const char* end = text.data() + text.size();
  const bool has_port = colon != std::string::npos && colon + 1 < text.size();
  const auto parsed = has_port ? std::from_chars(text.data() + colon + 1, end, address.port)
                               : std::from_chars_result{nullptr, std::errc::invalid_argument};
  if (parsed.ec != std::errc() || parsed.ptr != end || address.port < 0 || address.port > 65535)
    throw Error(
        ErrorCode::kUsage,
        fmt::format("'{}': expected an address to listen on, e.g. 127.0.0.1:8470, [::1]:8470 or unix:PATH", text));
  address.host = text.substr(0, colon);
  if (address.host.starts_with('[') && address.host.ends_with(']'))
    address.host = address.host.substr(1, address.host.size() - 2);
  if (address.host == "localhost") address.host = "127.0.0.1";
  return address;
}

namespace {

// Resolves the symbolic links in the existing part of a path.
std::string canonical_name(const std::string& path) {
  std::error_code error;
  const std::filesystem::path name = std::filesystem::weakly_canonical(std::filesystem::absolute(path), error);
  return error ? path : name.string();
}

bool is_in(const std::string& path, const std::string& folder) {
  return folder == "/" || path == folder || path.starts_with(folder + "/");
}

void check_roots(const ServiceSettings& settings, const std::string& settings_file, const Confinement& system) {
  if (settings.roots.empty())
    throw Error(
        ErrorCode::kUsage,
        "no roots are set; name the folders that jobs may read and write with --root, or with roots in the settings");
  const std::string socket = parse_listen_address(settings.listen).unix_path;
  const std::pair<const char*, std::string> own[] = {{"the data folder", settings.data},
                                                     {"the token", settings.token_file},
                                                     {"the settings file", settings_file},
                                                     {"the socket", socket},
                                                     {"the folder of [slurm]", settings.slurm.folder}};
  for (const std::string& path : {settings.data, settings.token_file})
    if (const std::string part = path.empty() ? "" : part_that_holds(system, path); !part.empty())
      throw Error(
          ErrorCode::kUsage,
          fmt::format(
              "{} is in {}, which every worker can read because of its libraries and drivers; expected another folder",
              path, part));
  for (const std::string& named : settings.roots) {
    const std::string root = canonical_name(named);
    for (const auto& [what, path] : own)
      if (!path.empty() && is_in(canonical_name(path), root))
        throw Error(
            ErrorCode::kUsage,
            fmt::format("{} {} is in the root {}, where jobs could write to it; expected a path outside of that root",
                        what, path, named));
    if (is_in(root, canonical_name(settings.data)))
      throw Error(
          ErrorCode::kUsage,
          fmt::format("the root {} is in the data folder {}, expected a folder outside of it", named, settings.data));
  }
}

// A user who can write to this folder could make nodes run any command.
void check_slurm(const SlurmSettings& settings) {
  if (!settings.is_on()) return;
  struct stat found {};
  if (::stat(settings.folder.c_str(), &found) != 0 || !S_ISDIR(found.st_mode))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("the folder of [slurm] {}: expected a folder with the same path on all nodes", settings.folder));
  if (found.st_uid != ::geteuid() || (found.st_mode & 022) != 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("the folder of [slurm] {}: other users own it or can write to it, expected a folder that "
                            "only the user of the service can use (chmod 700)",
                            settings.folder));
}

}  // namespace

void check_service_settings(const ServiceSettings& settings, const std::string& settings_file,
                            const Confinement& system) {
  const ListenAddress address = parse_listen_address(settings.listen);
  if (!address.is_loopback() && settings.token_file.empty())
    throw Error(
        ErrorCode::kUsage,
        fmt::format("other machines can reach '{}': this needs a token (--token-file), and a reverse proxy that adds "
                    "TLS (docs/reference/service.md)",
                    settings.listen));
  check_roots(settings, settings_file, system);
  check_slurm(settings.slurm);
}

}  // namespace multum
