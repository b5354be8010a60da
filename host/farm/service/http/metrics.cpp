// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/metrics.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>

namespace multum {
namespace {

// Escapes backslash, quote and line feed in label values.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\' || c == '"') result += '\\';
    if (c == '\n') result += "\\n";
    else result += c;
  }
  return result;
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

class Text {
 public:
  void begin(const char* name, const char* type, const char* help) {
    name_ = name;
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <typename Value>
  void add(const std::string& labels, Value value) {
    text_ += labels.empty() ? fmt::format("{} {}\n", name_, value) : fmt::format("{}{{{}}} {}\n", name_, labels, value);
  }
  template <typename Value>
  void one(const char* name, const char* type, const char* help, Value value) {
    begin(name, type, help);
    add("", value);
  }
  const std::string& text() const { return text_; }

 private:
  std::string name_, text_;
};

void add_slurm(Text& text, const SlurmPool& slurm) {
  const SlurmPool::Counters& c = slurm.counters();
  text.one("multum_slurm_up", "gauge", "1 if Slurm answered the last request, else 0.", slurm.is_up() ? 1 : 0);
  text.begin("multum_slurm_parts", "gauge", "Job parts submitted to Slurm, by Slurm state.");
  for (const auto& [state, count] : slurm.states()) text.add(fmt::format("state=\"{}\"", escaped(state)), count);
  text.one("multum_slurm_submitted_total", "counter", "Jobs that sbatch accepted.", c.submitted);
  text.one("multum_slurm_submit_failures_total", "counter",
           "Failed calls of sbatch, and failed attempts to write orders.", c.submit_failures);
  text.one("multum_slurm_submit_seconds_total", "counter", "Time spent writing orders and running sbatch.",
           c.submit_seconds);
  text.one("multum_slurm_sent_again_total", "counter",
           "Jobs that were sent again because Slurm lost them or did not start them.", c.forgotten);
  text.one("multum_slurm_unknown_cancelled_total", "counter",
           "Slurm jobs cancelled because they were not in the ledger.", c.cancelled_unknown);
  text.one("multum_slurm_parts_ended_total", "counter", "Job parts that have ended, with any outcome.", c.parts_ended);
  text.one("multum_slurm_parts_lost_total", "counter", "Job parts whose Slurm task was lost.", c.parts_lost);
  text.one("multum_slurm_rounds_total", "counter", "Repeated requests for missing shares of a map.", c.rounds);
}

}  // namespace

std::string metrics_text(const std::map<std::string, std::map<JobState, std::int64_t>>& jobs,
                         const Dispatcher& dispatcher, const HttpServer::Counters& http, std::size_t ledger_pending) {
  Text text;
  text.begin("multum_jobs", "gauge", "Jobs in the ledger, by queue and state.");
  for (const auto& [queue, states] : jobs)
    for (const auto& [state, count] : states)
      text.add(fmt::format("queue=\"{}\",state=\"{}\"", escaped(queue), job_state_name(state)), count);
  const Dispatcher::Counters& c = dispatcher.counters();
  text.begin("multum_attempts_total", "counter", "Attempts that have ended since the daemon started, by outcome.");
  text.add("outcome=\"succeeded\"", c.succeeded);
  text.add("outcome=\"failed\"", c.failed);
  text.add("outcome=\"lost\"", c.lost);
  text.add("outcome=\"cancelled\"", c.cancelled);
  text.one("multum_results_published_total", "counter", "Results published since the daemon started.", c.published);
  text.one("multum_results_reused_total", "counter", "Results copied from an earlier job with the same key.", c.reused);
  text.one("multum_busy_seconds_total", "counter", "Time that workers spent on jobs, summed over all workers.",
           c.busy_seconds);
  text.one("multum_workers", "gauge", "Worker processes.", dispatcher.workers().live_count());
  text.one("multum_workers_started_total", "counter", "Worker processes started.",
           dispatcher.workers().started_count());
  text.one("multum_workers_lost_total", "counter", "Worker processes that died or were killed.",
           dispatcher.workers().lost_count());
  if (const SlurmPool* slurm = dispatcher.slurm()) add_slurm(text, *slurm);
  text.one("multum_ledger_pending", "gauge", "Requests that are waiting for the ledger.", ledger_pending);
  text.one("multum_http_connections_total", "counter", "Connections accepted.", http.connections);
  text.one("multum_http_connections_refused_total", "counter", "Connections closed because there were too many.",
           http.refused_connections);
  text.one("multum_http_timeouts_total", "counter", "Connections closed because they were too slow.", http.timeouts);
  text.one("multum_http_connections", "gauge", "Open connections.", http.open);
  text.one("multum_http_failures_total", "counter", "Connections dropped because memory was short.", http.failures);
  text.one("multum_http_memory_bytes", "gauge", "Memory used by requests and answers in progress.", http.memory);
  text.one("multum_http_event_streams", "gauge", "Open streams of events.", http.streams);
  text.begin("multum_http_responses_total", "counter", "Answers by status.");
  for (const auto& [status, count] : http.by_status) text.add(fmt::format("status=\"{}\"", status), count);
  text.one("process_resident_memory_bytes", "gauge", "Resident memory of the daemon.", resident_bytes());
  return text.text();
}

}  // namespace multum
