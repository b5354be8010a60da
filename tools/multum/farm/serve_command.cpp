// SPDX-License-Identifier: Apache-2.0
// Implements multum serve, which runs the daemon or rescues its damaged ledger. The daemon starts the hidden command
// `worker`. Slurm starts the hidden command `slurm-task` for the daemon.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "host/farm/service/ledger/ledger_rescue.h"
#include "host/farm/service/service.h"
#include "host/farm/service/slurm/slurm_task.h"
#include "host/farm/service/workers/input_list.h"
#include "host/farm/service/workers/worker_loop.h"
#include "host/formats/opencl/kernel_caches.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/sandbox/confinement.h"
#include "tools/multum/farm/farm_commands.h"

namespace multum {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

struct ServeOptions {
  std::string data, config;
  std::string listen, token_file;
  std::vector<std::string> roots;
  int workers = 0;
  bool begins_anew = false, rescues = false;
};

// Reads the settings file. Options on the command line override its settings.
ServiceSettings settings_of(const ServeOptions& o) {
  ServiceSettings settings;
  settings.data = std::filesystem::absolute(o.data).string();
  if (!o.config.empty()) read_service_settings(o.config, settings);
  if (!o.listen.empty()) settings.listen = o.listen;
  if (!o.token_file.empty()) settings.token_file = o.token_file;
  if (!o.roots.empty()) settings.roots = o.roots;
  if (o.workers > 0) settings.workers = o.workers;
  return settings;
}

int run_serve(const ServeOptions& o) {
  const ServiceSettings settings = settings_of(o);
  prepare_kernel_caches();  // runs before workers lose the right to write to the caches
  const int cores = processor_count();
  const int threads = settings.threads_a_worker > 0 ? settings.threads_a_worker : std::max(1, cores / settings.workers);
  std::vector<std::string> worker = {own_program(), "worker", "--threads=" + std::to_string(threads),
                                     "--data=" + settings.data};
  for (const std::string& root : settings.roots) worker.push_back("--root=" + std::filesystem::absolute(root).string());
  const std::vector<std::string> driver = {own_program(), "confined", "--", own_program(), "devices"};
  run_service({settings, o.config, [o] { return settings_of(o); }, worker, driver, system_confinement(variable),
               o.begins_anew});
  return 0;
}

int run_rescue(const std::string& data) {
  const RescueReport report = rescue_ledger(std::filesystem::absolute(data).lexically_normal().string());
  for (const RescueReport::Table& table : report.tables)
    print_shown(stdout, "%-10s %lld rows saved, %lld were damaged\n", table.name.c_str(),
                static_cast<long long>(table.saved), static_cast<long long>(table.damaged));
  print_shown(stdout, "the damaged ledger is kept as %s\n", report.kept.c_str());
  return 0;
}

void check_rescue(const ServeOptions& o) {
  if (o.begins_anew || o.workers > 0 || !o.config.empty() || !o.listen.empty() || !o.token_file.empty() ||
      !o.roots.empty())
    throw Error(ErrorCode::kUsage,
                "found other options with --rescue, expected only --data, because no service is started");
}

struct WorkerOptions {
  int socket = -1, threads = 1;
  std::string data;
  std::vector<std::string> roots;
};

// Restricts a job to files below the roots and in the daemon's data folders for jobs, so that no picture, scene or link
// can lead to another folder.
void confine_worker(const WorkerOptions& o, const std::string& scratch) {
  Confinement allowed = system_confinement(variable);
  allowed.writable.insert(allowed.writable.end(), o.roots.begin(), o.roots.end());
  allowed.writable.insert(allowed.writable.end(), {o.data + "/results", o.data + "/logs", scratch});
  allowed.readable.push_back(o.data + "/uploads");
  confine_this_thread(allowed);
}

int run_worker_process(const WorkerOptions& o) {
  // Makes the operating system kill a worker before the daemon when memory runs out.
  std::ofstream("/proc/self/oom_score_adj") << 500;
  keep_freed_memory();
  const std::string scratch = o.data + "/scratch";
  ::setenv("TMPDIR", scratch.c_str(), 1);
  confine_worker(o, scratch);
  std::vector<std::string> inputs = o.roots;
  inputs.insert(inputs.end(), {o.data + "/uploads", o.data + "/results"});
  return run_worker(o.socket, inputs,
                    [threads = o.threads](std::vector<std::string> arguments, const Progress::Callback& callback) {
                      arguments.insert(arguments.begin() + 1, "--threads=" + std::to_string(threads));
                      return run_command_heard(arguments, callback);
                    });
}

// SLURM_ARRAY_TASK_ID is the number of this task in its array.
int run_task(const std::string& batch) {
  const std::string task = variable("SLURM_ARRAY_TASK_ID");
  std::optional<int> item;
  if (!task.empty()) item = std::atoi(task.c_str());
  return run_slurm_task(batch, item, [](const SlurmOrder& order, const std::string& work_folder) {
    std::vector<std::string> worker = {own_program(), "worker", "--threads=" + std::to_string(order.threads),
                                       "--data=" + work_folder};
    for (const std::string& root : order.roots) worker.push_back("--root=" + root);
    return worker;
  });
}

struct InputsOptions {
  std::string type, parameters;
  std::vector<std::string> roots;
};

struct ConfinedOptions {
  std::vector<std::string> readable, writable, command;
};

// Confines this process, then replaces it with another program.
int run_confined(const ConfinedOptions& o) {
  Confinement allowed = system_confinement(variable);
  allowed.readable.insert(allowed.readable.end(), o.readable.begin(), o.readable.end());
  allowed.writable.insert(allowed.writable.end(), o.writable.begin(), o.writable.end());
  confine_this_thread(allowed);
  std::vector<char*> words;
  for (const std::string& word : o.command) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execv(words.front(), words.data());
  fail_by_errno(o.command.front(), "cannot start");
}

}  // namespace

void add_serve_commands(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* serve =
      app.add_subcommand("serve", "run a service that bakes maps for its clients (docs/reference/service.md)");
  serve->add_option("--data", options->data, "folder for the ledger, logs and uploads; a missing folder is created")
      ->required();
  serve->add_option("--listen", options->listen,
                    "listen on HOST:PORT, [::1]:PORT or unix:PATH (default: 127.0.0.1:8470)");
  serve
      ->add_option("--root", options->roots,
                   "allow jobs to read and write below this folder, which must not contain files of the service; can "
                   "be repeated")
      ->allow_extra_args(false);
  serve->add_option("--workers", options->workers, "run this many jobs at once (default: 2)")
      ->check(CLI::Range(1, 256));
  serve->add_option("--token-file", options->token_file, "file whose first line is the token that clients must send");
  serve->add_option("--config", options->config,
                    "read the settings from this TOML file; command-line options override"
                    " them");
  CLI::Option* const begins_anew = serve->add_flag("--new-ledger", options->begins_anew,
                                                   "start a new ledger if the ledger is lost; no files are removed");
  serve
      ->add_flag("--rescue", options->rescues,
                 "copy the readable jobs of a damaged ledger into a new ledger, and exit; the service must not be "
                 "running")
      ->excludes(begins_anew);
  serve->callback([options, exit_code] {
    if (options->rescues) check_rescue(*options);
    *exit_code = options->rescues ? run_rescue(options->data) : run_serve(*options);
  });

  // Hidden commands, which the service starts.
  auto own = std::make_shared<WorkerOptions>();
  CLI::App* worker = app.add_subcommand("worker", "");
  worker->group("");
  worker->add_option("--socket", own->socket)->required();
  worker->add_option("--threads", own->threads);
  worker->add_option("--data", own->data)->required();
  worker->add_option("--root", own->roots)->allow_extra_args(false);
  worker->callback([own, exit_code] { *exit_code = run_worker_process(*own); });

  auto batch = std::make_shared<std::string>();
  CLI::App* task = app.add_subcommand("slurm-task", "");
  task->group("");
  task->add_option("--batch", *batch)->required();
  task->callback([batch, exit_code] { *exit_code = run_task(*batch); });

  auto list = std::make_shared<InputsOptions>();
  CLI::App* inputs = app.add_subcommand("inputs", "");
  inputs->group("");
  inputs->add_option("--type", list->type)->required();
  inputs->add_option("--parameters", list->parameters)->required();
  inputs->add_option("--root", list->roots)->allow_extra_args(false);
  inputs->callback([list, exit_code] {
    print_input_list(list->type, list->parameters, list->roots, system_confinement(variable));
    *exit_code = 0;
  });

  auto other = std::make_shared<ConfinedOptions>();
  CLI::App* confined = app.add_subcommand("confined", "");
  confined->group("");
  confined->add_option("--read", other->readable)->allow_extra_args(false);
  confined->add_option("--write", other->writable)->allow_extra_args(false);
  confined->add_option("command", other->command)->required();
  confined->callback([other, exit_code] { *exit_code = run_confined(*other); });
}

}  // namespace multum
