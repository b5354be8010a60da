// SPDX-License-Identifier: Apache-2.0
// Implements multum jobs submit|list|show|cancel|retry|tail|wait|purge, the client of a service.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <thread>

#include "host/farm/service/http/http_client.h"
#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/workers/job_types.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"
#include "tools/multum/farm/farm_commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

struct ClientOptions {
  std::string server, token_file;
  bool json = false;
};

// Connects to the server given by --server or $MULTUM_SERVER, or else to the default server.
HttpClient client_of(const ClientOptions& o) {
  const char* from_environment = std::getenv("MULTUM_SERVER");
  const std::string server = !o.server.empty()             ? o.server
                             : from_environment != nullptr ? from_environment
                                                           : "http://127.0.0.1:8470";
  const char* token_from_environment = std::getenv("MULTUM_TOKEN_FILE");
  const std::string token_file = !o.token_file.empty()               ? o.token_file
                                 : token_from_environment != nullptr ? token_from_environment
                                                                     : "";
  std::string token;
  if (!token_file.empty()) {
    RegularFileStream file(token_file, StandardInput::kAllowed);
    if (!std::getline(file, token)) throw Error(ErrorCode::kInput, "cannot read the token file " + token_file);
  }
  return HttpClient(server, token);
}

void add_client_options(CLI::App& command, ClientOptions& o) {
  command.add_option("--server", o.server,
                     "set the address of the service, http://HOST:PORT or unix:PATH (default: $MULTUM_SERVER, else "
                     "http://127.0.0.1:8470)");
  command.add_option("--token-file", o.token_file,
                     "read the service token from the first line of this file (default: $MULTUM_TOKEN_FILE)");
  add_json_option(command, o.json);
}

constexpr std::size_t kMessageMax = 120;  // maximum length in bytes of a message in a list with one line per job

// Returns the first line of a message, cut to kMessageMax bytes.
std::string short_message(const std::string& message) {
  const std::string line = message.substr(0, message.find('\n'));
  if (line.size() <= kMessageMax) return line == message ? line : line + " ...";
  return line.substr(0, whole_characters(line.substr(0, kMessageMax))) + " ...";
}

std::string job_line(const Json& job, std::string message) {
  std::string line =
      fmt::format("{:>6}  {:<10} {:<8} {}", job["id"].get<std::int64_t>(), job["state"].get<std::string>(),
                  job["type"].get<std::string>(), path_of_text(job["output"].get<std::string>()));
  if (job.contains("progress") && job["progress"].is_object() && job["progress"]["total"].get<double>() > 0.0)
    line += fmt::format("  {:.0f} % {}",
                        100.0 * job["progress"]["done"].get<double>() / job["progress"]["total"].get<double>(),
                        job["progress"]["stage"].get<std::string>());
  if (!message.empty()) line += "  (" + message + ")";
  return line;
}

std::string job_line(const Json& job) { return job_line(job, job["message"].get<std::string>()); }

// Prints jobs as one line per job, or as one JSON document at the end.
class PrintedJobs {
 public:
  explicit PrintedJobs(const ClientOptions& o) : json_(o.json) {}
  void add(const Json& job) {
    if (json_) jobs_.push_back(OrderedJson(job));
    else print_shown(stdout, "%s\n", job_line(job).c_str());
  }
  void finish() const {
    if (json_) print_json({{"jobs", jobs_}});
  }
  const OrderedJson& jobs() const { return jobs_; }

 private:
  bool json_;
  OrderedJson jobs_ = OrderedJson::array();
};

// Prints one line per field.
void print_fields(const Json& job) {
  for (const auto& [key, value] : job.items())
    write_shown(stdout, fmt::format("{:<14} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump()));
}

// ---- submit

struct SubmitOptions {
  ClientOptions client;
  std::string output;
  Job asked;  // holds only fields with an option; `deadline` is in seconds from now
  bool again = false, wait = false;
  std::map<std::string, std::string> values;
  std::map<std::string, bool> flags;
};

// Returns the value as JSON. A string that cannot be parsed is sent unchanged, because the service's error message says
// what was expected.
Json value_of(const Parameter& parameter, const std::string& text) {
  if (parameter.kind == ParameterKind::kFile) {
    // Also works for FILE:CHANNEL, because the channel still follows the last colon.
    return text_of_path(fs::absolute(text).lexically_normal().string());
  }
  const std::optional<ParameterValue> value = parse_value(parameter, text);
  if (!value) return text;
  return std::visit([](const auto& one) { return Json(one); }, *value);
}

bool wait_for(HttpClient& client, std::set<std::int64_t> ids, PrintedJobs& printed);

// Adds a field if its value differs from the default of a job.
template <typename Value>
void add_asked(Json& job, const JobField& field, const Value& value) {
  static const Job kNone;
  if (value == kNone.*std::get<Value Job::*>(field.member)) return;
  if constexpr (std::is_same_v<Value, std::optional<std::int64_t>>) job[field.asked_as] = *value;
  else if constexpr (!std::is_same_v<Value, std::optional<int>>) job[field.asked_as] = value;
}

template <typename Value>
void add_field_option(CLI::App& command, const JobField& field, Value& value) {
  if constexpr (!std::is_same_v<Value, JobState> && !std::is_same_v<Value, std::optional<int>>) {
    CLI::Option* const option = command.add_option(field.option, value, field.option_help);
    if (field.has_default) option->capture_default_str();
    if (field.form == JobField::Form::kBytes) option->transform(CLI::AsSizeValue(false));
    if constexpr (std::is_same_v<Value, std::vector<std::int64_t>>) option->delimiter(',');
  }
}

int run_submit(const JobType& type, SubmitOptions& o) {
  Json parameters = Json::object();
  for (const Parameter& parameter : type.table->rows()) {
    if (o.flags[parameter.name]) parameters[parameter.name] = true;
    if (const auto found = o.values.find(parameter.name); found != o.values.end() && !found->second.empty())
      parameters[parameter.name] = value_of(parameter, found->second);
  }
  Json job = {{"type", type.name}, {"parameters", parameters}};
  if (!o.output.empty()) job["output"] = text_of_path(fs::absolute(o.output).lexically_normal().string());
  for (const JobField& field : job_fields()) {
    if (field.option == nullptr) continue;
    with_field(field, o.asked, [&](const auto& value) { add_asked(job, field, value); });
  }
  if (o.again) job["again"] = true;
  HttpClient client = client_of(o.client);
  const Json answer = client.ask("POST", "/v1/jobs", job);
  const auto id = answer["id"].get<std::int64_t>();
  if (!o.client.json) print_shown(stdout, "%lld\n", static_cast<long long>(id));
  if (!o.wait) {
    if (o.client.json) print_json(OrderedJson(answer));
    return 0;
  }
  PrintedJobs printed(o.client);
  const bool succeeded = wait_for(client, {id}, printed);
  if (o.client.json) print_json(printed.jobs().front());
  return succeeded ? 0 : 1;
}

CLI::Validator is_choice(const Parameter& parameter) {
  const auto check = [&parameter](const std::string& text) {
    return is_legal(parameter, text) ? "" : fmt::format("found {}, expected {}", text, expected_text(parameter));
  };
  return {check, fmt::format("{{{}}}", fmt::join(parameter.choices, ","))};
}

void add_submit_option(CLI::App& command, SubmitOptions& o, const Parameter& parameter) {
  const std::string& name = parameter.name;
  if (parameter.kind == ParameterKind::kFlag) {
    command.add_flag(option_of(name), o.flags[name], parameter.help);
    return;
  }
  CLI::Option* const option = command.add_option(option_of(name), o.values[name], parameter.help);
  if (!parameter.default_text.empty()) option->default_str(parameter.default_text);
  if (parameter.kind == ParameterKind::kChoice) option->check(is_choice(parameter));
}

void add_submit(CLI::App& app, int* exit_code) {
  CLI::App* submit = app.add_subcommand("submit", "submit a job to a service and print its number");
  submit->footer("Example:\n  multum jobs submit bake rock_normal.png -o /srv/maps/rock.ndf.exr --lobes 4 --wait");
  submit->require_subcommand(1);
  for (const JobType& type : job_types()) {
    auto o = std::make_shared<SubmitOptions>();
    CLI::App* command = submit->add_subcommand(type.name, type.summary);
    for (const Parameter& parameter : type.table->rows()) {
      if (!parameter.is_on(kInService)) continue;
      if (parameter.name == type.input) {
        command->add_option(parameter.name, o->values[parameter.name], parameter.help)->required();
      } else {
        add_submit_option(*command, *o, parameter);
      }
    }
    CLI::Option* output = command->add_option("-o,--output", o->output, "output file or folder, on the service's disk");
    if (type.needs_output) output->required();
    for (const JobField& field : job_fields())
      // For job types with a --device parameter, --device chooses the OpenCL device.
      if (field.option != nullptr && command->get_option_no_throw(field.option) == nullptr)
        with_field(field, o->asked, [&](auto& value) { add_field_option(*command, field, value); });
    command->add_flag("--again", o->again, "run the job even if an earlier job made the same result");
    command->add_flag("--wait", o->wait, "wait until the job ends, and exit with code 0 if it succeeded, else with 1");
    add_client_options(*command, o->client);
    command->callback([&type, o, exit_code] { *exit_code = run_submit(type, *o); });
  }
}

// ---- wait, tail

// The time for which a waiting client tries to reach a service that does not answer. It is long enough for a restart of
// the service.
constexpr auto kPatience = std::chrono::seconds(60);

// Calls `body`, which communicates with the service, until it returns true. `body` calls `answered` after each answer.
void persist(const std::function<bool(const std::function<void()>& answered)>& body) {
  using Clock = std::chrono::steady_clock;
  bool was_answered = false;
  std::optional<Clock::time_point> gone_since;
  const auto answered = [&] {
    was_answered = true;
    gone_since.reset();
  };
  for (;;) {
    try {
      if (body(answered)) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));  // the connection was lost
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kEnvironment || !was_answered) throw;
      if (!gone_since) print_shown(stderr, "multum: %s Trying again.\n", error.what());
      gone_since = gone_since.value_or(Clock::now());
      if (Clock::now() - *gone_since > kPatience) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
    }
  }
}

// Returns whether all jobs succeeded.
bool wait_for(HttpClient& client, std::set<std::int64_t> ids, PrintedJobs& printed) {
  bool all_succeeded = true;
  const auto settle = [&](const Json& job) {
    const auto state = job["state"].get<std::string>();
    if (state != "succeeded" && state != "dead" && state != "cancelled") return;
    if (ids.erase(job["id"].get<std::int64_t>()) == 0) return;
    all_succeeded = all_succeeded && state == "succeeded";
    printed.add(job);
  };
  if (ids.empty()) return true;
  persist([&](const std::function<void()>& answered) {
    // Asks for the jobs that are already done. The event stream is already open at this time, because events report
    // only changes.
    const auto ask_all = [&] {
      answered();
      const std::set<std::int64_t> asked = ids;
      for (const std::int64_t id : asked) settle(client.ask("GET", fmt::format("/v1/jobs/{}", id)));
      return !ids.empty();
    };
    const std::string target = ids.size() == 1 ? fmt::format("/v1/jobs/{}/events", *ids.begin()) : "/v1/events";
    client.listen(target, ask_all, [&](const std::string& kind, const Json& data) {
      answered();
      if (kind == "job" && data.is_object()) settle(data);
      return !ids.empty();
    });
    return ids.empty();
  });
  return all_succeeded;
}

struct WaitOptions {
  ClientOptions client;
  std::vector<std::int64_t> ids;
  bool all = false;
};

int run_wait(WaitOptions& o) {
  HttpClient client = client_of(o.client);
  std::set<std::int64_t> ids(o.ids.begin(), o.ids.end());
  if (o.all) {
    for (const char* state : {"waiting", "queued", "running", "publishing"}) {
      std::string target = fmt::format("/v1/jobs?state={}&limit=1000", state);
      for (;;) {
        const Json jobs = client.ask("GET", target)["jobs"];
        for (const Json& job : jobs) ids.insert(job["id"].get<std::int64_t>());
        if (jobs.size() < 1000) break;
        target = fmt::format("/v1/jobs?state={}&limit=1000&before={}", state, jobs.back()["id"].get<std::int64_t>());
      }
    }
  } else if (ids.empty()) {
    throw Error(ErrorCode::kUsage, "found neither a job number nor --all, expected one of them");
  }
  PrintedJobs printed(o.client);
  const bool succeeded = wait_for(client, std::move(ids), printed);
  printed.finish();
  return succeeded ? 0 : 1;
}

int run_tail(ClientOptions& o, std::int64_t id) {
  HttpClient client = client_of(o);
  std::size_t shown = 0;  // number of bytes shown
  std::string state, log;
  Json job;
  const auto show = [&] {
    job = client.ask("GET", fmt::format("/v1/jobs/{}", id));
    log = client.text(fmt::format("/v1/jobs/{}/log", id));
    state = job["state"].get<std::string>();
    const bool is_done = state == "succeeded" || state == "dead" || state == "cancelled";
    // A character that is split between two answers would be shown as two invalid characters, so its first part is kept
    // until the rest arrives.
    const std::size_t ready = is_done ? log.size() : whole_characters(log);
    if (ready > shown && !o.json) write_shown(stdout, std::string_view(log).substr(shown, ready - shown));
    shown = std::max(shown, ready);
    if (is_done) print_shown(stderr, "%s\n", job_line(job).c_str());
    return !is_done;
  };
  persist([&](const std::function<void()>& answered) {
    bool goes_on = true;
    const auto look = [&] {
      answered();
      goes_on = show();
      return goes_on;
    };
    client.listen(fmt::format("/v1/jobs/{}/events", id), look, [&](const std::string&, const Json&) { return look(); });
    return !goes_on;
  });
  if (o.json) print_json({{"job", OrderedJson(job)}, {"log", log}});
  return state == "succeeded" ? 0 : 1;
}

// ---- Other commands

template <typename Body>
void add_for_ids(CLI::App& app, const char* name, const char* help, int* exit_code, Body body) {
  struct Options {
    ClientOptions client;
    std::vector<std::int64_t> ids;
  };
  auto o = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(name, help);
  command->add_option("job", o->ids, "numbers of the jobs")->required();
  add_client_options(*command, o->client);
  command->callback([o, exit_code, body] {
    HttpClient client = client_of(o->client);
    PrintedJobs printed(o->client);
    for (const std::int64_t id : o->ids) body(client, o->client, id, printed);
    printed.finish();
    *exit_code = 0;
  });
}

void add_list(CLI::App& app, int* exit_code) {
  struct Options {
    ClientOptions client;
    std::string state, queue;
    int limit = 50;
  };
  auto o = std::make_shared<Options>();
  CLI::App* list = app.add_subcommand("list", "list the jobs of a service, newest first");
  list->add_option("--state", o->state, "list only jobs in this state")
      ->check(CLI::IsMember({"waiting", "queued", "running", "publishing", "succeeded", "dead", "cancelled"}));
  list->add_option("--queue", o->queue, "list only jobs in this queue");
  list->add_option("--limit", o->limit, "list at most this many jobs")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  add_client_options(*list, o->client);
  list->callback([o, exit_code] {
    std::string target = fmt::format("/v1/jobs?limit={}", o->limit);
    if (!o->state.empty()) target += "&state=" + o->state;
    if (!o->queue.empty()) target += "&queue=" + o->queue;
    const Json answer = client_of(o->client).ask("GET", target);
    if (o->client.json) {
      print_json(OrderedJson(answer));
    } else {
      for (const Json& job : answer["jobs"])
        print_shown(stdout, "%s\n", job_line(job, short_message(job["message"].get<std::string>())).c_str());
    }
    *exit_code = 0;
  });
}

void add_retry(CLI::App& app, int* exit_code) {
  struct Options {
    ClientOptions client;
    std::vector<std::int64_t> ids;
    bool all_dead = false;
    std::string queue;
  };
  auto o = std::make_shared<Options>();
  CLI::App* retry = app.add_subcommand("retry", "queue dead or cancelled jobs again");
  retry->add_option("job", o->ids, "numbers of the jobs");
  retry->add_flag("--all-dead", o->all_dead, "retry all dead jobs");
  retry->add_option("--queue", o->queue, "with --all-dead, retry only the dead jobs of this queue");
  add_client_options(*retry, o->client);
  retry->callback([o, exit_code] {
    if (o->all_dead == !o->ids.empty())
      throw Error(ErrorCode::kUsage, fmt::format("found {}, expected either job numbers or --all-dead",
                                                 o->all_dead ? "both" : "neither a job number nor --all-dead"));
    HttpClient client = client_of(o->client);
    if (!o->all_dead) {
      PrintedJobs printed(o->client);
      for (const std::int64_t id : o->ids) printed.add(client.ask("POST", fmt::format("/v1/jobs/{}/retry", id)));
      printed.finish();
    } else {
      const Json answer =
          client.ask("POST", "/v1/retry", o->queue.empty() ? Json::object() : Json{{"queue", o->queue}});
      if (o->client.json) print_json(OrderedJson(answer));
      else print_shown(stdout, "%zu jobs are queued again\n", answer["retried"].size());
    }
    *exit_code = 0;
  });
}

void add_purge(CLI::App& app, int* exit_code) {
  struct Options {
    ClientOptions client;
    std::vector<std::int64_t> ids;
    std::int64_t age = -1;
  };
  auto o = std::make_shared<Options>();
  CLI::App* purge = app.add_subcommand(
      "purge", "remove finished jobs, their logs, and their results in the folder of the service; keep other results");
  purge->add_option("job", o->ids, "numbers of the jobs");
  purge->add_option("--older-than", o->age, "purge all jobs that ended at least this many seconds ago")
      ->check(CLI::NonNegativeNumber);
  add_client_options(*purge, o->client);
  purge->callback([o, exit_code] {
    if (o->ids.empty() == (o->age < 0))
      throw Error(ErrorCode::kUsage, fmt::format("found {}, expected either job numbers or --older-than",
                                                 o->age < 0 ? "neither a job number nor --older-than" : "both"));
    const Json body = o->age < 0 ? Json{{"jobs", o->ids}} : Json{{"finished_before_s", o->age}};
    const Json answer = client_of(o->client).ask("POST", "/v1/purge", body);
    if (o->client.json) print_json(OrderedJson(answer));
    else print_shown(stdout, "%zu jobs are purged\n", answer["purged"].size());
    *exit_code = 0;
  });
}

}  // namespace

void add_client_commands(CLI::App& program, int* exit_code) {
  CLI::App& app = *program.add_subcommand(
      "jobs", "submit, list, follow and manage the jobs of a service (docs/reference/service.md)");
  app.require_subcommand(1);
  add_submit(app, exit_code);
  add_list(app, exit_code);
  add_for_ids(app, "show", "show all fields of jobs", exit_code,
              [](HttpClient& client, const ClientOptions& o, std::int64_t id, PrintedJobs& printed) {
                const Json job = client.ask("GET", fmt::format("/v1/jobs/{}", id));
                if (o.json) printed.add(job);
                else print_fields(job);
              });
  add_for_ids(app, "cancel", "cancel jobs in any state", exit_code,
              [](HttpClient& client, const ClientOptions&, std::int64_t id, PrintedJobs& printed) {
                printed.add(client.ask("POST", fmt::format("/v1/jobs/{}/cancel", id)));
              });
  add_retry(app, exit_code);

  auto tail = std::make_shared<std::pair<ClientOptions, std::int64_t>>();
  CLI::App* tail_command = app.add_subcommand("tail", "print the log of a job until the job ends");
  tail_command->add_option("job", tail->second, "number of the job")->required();
  add_client_options(*tail_command, tail->first);
  tail_command->callback([tail, exit_code] { *exit_code = run_tail(tail->first, tail->second); });

  auto wait = std::make_shared<WaitOptions>();
  CLI::App* wait_command = app.add_subcommand("wait",
                                              "wait until jobs end, and exit with code 0 if all succeeded, "
                                              "else with 1");
  wait_command->add_option("job", wait->ids, "numbers of the jobs");
  wait_command->add_flag("--all", wait->all, "wait for all jobs that have not ended");
  add_client_options(*wait_command, wait->client);
  wait_command->callback([wait, exit_code] { *exit_code = run_wait(*wait); });
  add_purge(app, exit_code);
}

}  // namespace multum
