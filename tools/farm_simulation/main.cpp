// SPDX-License-Identifier: Apache-2.0
// The program multum-farm-simulation simulates bakes of many maps on many Slurm nodes in virtual time. The ledger (a
// JobQueue on a disk,
// with synced commits), the chunks and the files of the shared folder are real. Slurm's commands, the nodes, their
// failures and the bake times are simulated with random numbers. The measured time of real code is added to the virtual
// time.
//
//   commands' thread   squeue, files of all parts in Slurm's queue, then one sbatch per chunk  (slurm_pool.h)
//   ledger's thread    ends of parts, claims, notes: one transaction for each kind                (queue_thread.h)
//   nodes              one chunk each; after a node failure, the chunk restarts elsewhere, without its finished jobs
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <queue>
#include <random>

#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/slurm/slurm_plan.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/stopwatch.h"
#include "tools/command_line/usage_error.h"

namespace multum {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
  std::string folder, json;
  int maps = 1000000, nodes = 1000, jobs_max = 10000;
  double map_seconds = 20.0;  // median; kSpread is the standard deviation of the logarithm
  double chunk_seconds = SlurmSettings{}.chunk_seconds;
  double sbatch_seconds = 0.031;  // docs/evidence/SERVICE.md, "Slurm": measured with four nodes on one machine
  double file_seconds = 0.0005;   // one file access in the shared folder, which is a round trip to its server
  double fail_share = 0.01;       // share of attempts that fail and may be repeated
  double refuse_share = 0.001;    // share of maps that cannot be baked
  double node_hours = 200.0;      // mean time between two failures of a node
  double repair_seconds = 600.0;  // time until a failed node works again
  bool asks_for_each = false;     // ask for each file of each part, like earlier program versions, which could not list
                                  // folders
  unsigned seed = 1;
};

constexpr double kSpread = 0.5;
constexpr int kClaimsAtOnce = 200;                                  // as in dispatch/dispatcher.cpp
constexpr int kSubmissionsAtOnce = 256;                             // as in ledger/queue_thread.cpp
constexpr double kSqueueSeconds = 0.02, kSqueueTaskSeconds = 2e-5;  // time per call, and per line of the list
constexpr double kTaskStartSeconds = 0.5;                           // time per slot, for any task (slurm_plan.h)

JobSubmission submission_of(int map) {
  JobSubmission job;
  job.type = "bake";
  job.parameters = fmt::format(R"({{"input": "/farm/maps/{:04}/map_{:07}_normal.png", "lobes": 4}})", map / 1000, map);
  job.queue = "farm";
  job.label = fmt::format("map {}", map);
  job.output = fmt::format("/farm/maps/{:04}/map_{:07}.ndf.exr", map / 1000, map);
  job.key = fmt::format("{:064x}", map);
  job.inputs = fmt::format(R"([["/farm/maps/{:04}/map_{:07}_normal.png", "{:064x}"]])", map / 1000, map, map);
  job.memory_bytes = 1 << 30;
  return job;
}

LedgerSettings ledger_in(const std::string& folder) {
  LedgerSettings settings;
  settings.path = folder + "/jobs.sqlite";
  return settings;
}

// Selects the jobs that the page shows, which are the newest jobs of one state or of all states.
JobFilter newest_in(std::optional<JobState> state) {
  JobFilter filter;
  filter.state = state;
  filter.limit = 50;
  return filter;
}

SlurmPart part_of(std::int64_t batch, int item, std::int64_t job, int attempt) {
  SlurmPart part;
  part.batch = batch;
  part.item = item;
  part.job = job;
  part.attempt = attempt;
  return part;
}

struct Item {
  std::int64_t job;
  int attempt;
  double seconds;
  int code;  // exit code that the item will end with
  bool has_ended = false;
  double ended = -1.0;  // planned end while the item's chunk runs
};

struct Chunk {
  std::vector<Item> items;
  std::size_t reported = 0;  // number of items whose end the ledger knows
  bool runs = false;
};

// The seconds that the ledger's thread has used. Other programs on the machine increase only `elapsed`.
struct LedgerTime {
  double elapsed = 0.0, processor = 0.0;
};

class Simulation {
 public:
  explicit Simulation(const Options& options)
      : o_(options), queue_(ledger_in(options.folder)), random_(options.seed), free_nodes_(o_.nodes) {
    limits_.queues["farm"] = QueueLimits{};
  }

  Json run() {
    submit();
    look_at_page("full");
    next_sample_ = o_.maps / 2;
    while (finished_ < o_.maps) {
      const double began = now_;
      advance_nodes(began);
      look();
      note_ends();
      claim_and_send();
      now_ = std::max(now_, began + 1e-3 * static_cast<double>(SlurmSettings{}.poll.count()));
      if (finished_ >= next_sample_) {
        look_at_page("half");
        next_sample_ = o_.maps + 1;
      }
    }
    look_at_page("done");
    return report();
  }

 private:
  // Runs `body` as one transaction, and adds the time that it takes on the ledger's single thread.
  template <typename Body>
  void in_ledger(LedgerTime& time, const Body& body) {
    const Stopwatch stopwatch;
    const ThreadStopwatch processor;
    {
      SqliteTransaction transaction(queue_.database());
      body();
      transaction.commit();
    }
    queue_.take_changed();
    const double took = stopwatch.seconds();
    time.elapsed += took;
    time.processor += processor.seconds();
    ++commits_;
    now_ += took;
  }
  TimeMs clock() const { return static_cast<TimeMs>(1e3 * now_); }

  void submit() {
    for (int first = 0; first < o_.maps; first += kSubmissionsAtOnce)
      in_ledger(submit_, [&] {
        for (int map = first; map < std::min(o_.maps, first + kSubmissionsAtOnce); ++map)
          queue_.submit(
              submission_of(map), [](const Job&) { return false; }, clock());
      });
    work_began_ = now_;
  }

  // Runs the queries that the page sends every second, and the queries of a user who searches for failed jobs.
  void look_at_page(const std::string& when) {
    const auto milliseconds = [&](const auto& body) {
      double best = 1e9;
      for (int i = 0; i < 3; ++i) {
        const Stopwatch stopwatch;
        body();
        best = std::min(best, 1e3 * stopwatch.seconds());
      }
      return best;
    };
    Json row;
    row["when"] = when;
    row["counts_ms"] = milliseconds([&] { queue_.counts(); });
    row["newest_ms"] = milliseconds([&] { queue_.list(newest_in(std::nullopt)); });
    row["dead_ms"] = milliseconds([&] { queue_.list(newest_in(JobState::kDead)); });
    row["running_ms"] = milliseconds([&] { queue_.list(newest_in(JobState::kRunning)); });
    row["numbers_ms"] = milliseconds([&] { queue_.numbers(); });
    row["ledger_bytes"] = std::filesystem::file_size(o_.folder + "/jobs.sqlite");
    page_.push_back(row);
    std::fprintf(stderr, "%s\n", row.dump().c_str());
  }

  // ---- Nodes

  void start_chunks(double at) {
    while (free_nodes_ > 0 && !waiting_.empty()) {
      const std::int64_t batch = waiting_.front();
      waiting_.pop_front();
      --free_nodes_;
      Chunk& chunk = chunks_.at(batch);
      chunk.runs = true;
      double end = at + kTaskStartSeconds;
      const double failure = at + std::exponential_distribution<>(1.0 / (3600.0 * o_.node_hours))(random_);
      for (Item& item : chunk.items) {
        if (item.has_ended) continue;
        end += item.seconds;
        if (end > failure) break;
        item.ended = end;
      }
      if (end > failure) events_.push({failure, batch, true});
      else events_.push({end, batch, false});
      busy_seconds_ += std::min(end, failure) - at;
    }
  }

  void advance_nodes(double until) {
    start_chunks(until);
    while (!events_.empty() && events_.top().at <= until) {
      const Event event = events_.top();
      events_.pop();
      if (event.batch == 0) {
        ++free_nodes_;
      } else {
        Chunk& chunk = chunks_.at(event.batch);
        chunk.runs = false;
        for (Item& item : chunk.items)
          if (item.ended >= 0.0) item.has_ended = true;
        if (event.is_failure) {
          ++node_failures_;
          waiting_.push_front(event.batch);  // requeued by Slurm
          events_.push({event.at + o_.repair_seconds, 0, false});
        } else {
          ++free_nodes_;
        }
      }
      start_chunks(event.at);
    }
  }

  // ---- The daemon

  void look() {
    double files = 0.0;
    for (const auto& [batch, chunk] : chunks_) files += look_files(chunk);
    const double seconds =
        kSqueueSeconds + kSqueueTaskSeconds * static_cast<double>(chunks_.size()) + o_.file_seconds * files;
    looks_.push_back(seconds);
    look_seconds_ += seconds;
    now_ += seconds;
  }

  // Returns the number of requests that are sent to the folder's server when one chunk is checked (look_at_files()).
  double look_files(const Chunk& chunk) const {
    const auto parts = static_cast<double>(chunk.items.size() - chunk.reported);
    if (o_.asks_for_each) return kFilesAPart * parts + (chunk.runs ? kFilesOfLog : 0.0);
    return 1.0 + (chunk.runs ? 1.0 + (parts > 1.0 ? 1.0 : 0.0) + kFilesOfLog : 0.0);  // a status, the task's output
  }

  void note_ends() {
    struct End {
      std::int64_t batch;
      int item;
    };
    std::vector<End> ends;
    for (auto& [batch, chunk] : chunks_)
      for (std::size_t i = chunk.reported; i < chunk.items.size(); ++i) {
        if (chunk.items[i].ended < 0.0 || chunk.items[i].ended > now_) break;
        chunk.items[i].has_ended = true;
        ends.push_back({batch, static_cast<int>(i)});
        chunk.reported = i + 1;
      }
    for (std::size_t first = 0; first < ends.size(); first += kSubmissionsAtOnce)
      in_ledger(end_, [&] {
        for (std::size_t e = first; e < std::min(ends.size(), first + kSubmissionsAtOnce); ++e)
          note_end(ends[e].batch, ends[e].item);
      });
    // The last item of a chunk ends with its task, a moment before the node reports the end.
    std::erase_if(chunks_, [&](const auto& one) {
      const Chunk& chunk = one.second;
      if (chunk.reported < chunk.items.size() || chunk.runs) return false;
      with_slurm_ -= static_cast<int>(chunk.items.size());
      return true;
    });
  }

  void note_end(std::int64_t batch, int number) {
    const Item& item = chunks_.at(batch).items[static_cast<std::size_t>(number)];
    SlurmPart part = part_of(batch, number, item.job, item.attempt);
    part.state = item.code == 0 ? SlurmPartState::kSucceeded : SlurmPartState::kFailed;
    part.node = fmt::format("node{:04}", batch % o_.nodes);
    part.exit_code = item.code;
    queue_.slurm().update(part);
    if (item.code == 0) {
      MULTUM_CHECK(queue_.begin_publishing(item.job, kOwner, item.attempt, "identity"));
      queue_.published(item.job, clock());
      ++finished_;
      return;
    }
    const AttemptOutcome outcome = item.code == 3 ? AttemptOutcome::kRefused : AttemptOutcome::kFailed;
    MULTUM_CHECK(queue_.ended(item.job, kOwner, item.attempt, {outcome, item.code, "drawn"}, clock()));
    ++failures_;
    if (queue_.find(item.job)->state == JobState::kDead) ++finished_;
  }

  void claim_and_send() {
    while (with_slurm_ < o_.jobs_max) {
      const int room = std::min(kClaimsAtOnce, o_.jobs_max - with_slurm_);
      std::vector<Job> jobs;
      in_ledger(claim_, [&] {
        for (int i = 0; i < room; ++i) {
          std::optional<Job> job = queue_.claim(limits_, kOwner, clock());
          if (!job) break;
          jobs.push_back(std::move(*job));
        }
        queue_.next_due();
      });
      if (jobs.empty()) return;
      send(jobs);
    }
  }

  void send(const std::vector<Job>& jobs) {
    std::vector<double> seconds;
    for (std::size_t i = 0; i < jobs.size(); ++i)
      seconds.push_back(o_.map_seconds * std::exp(kSpread * std::normal_distribution<>()(random_)));
    std::vector<std::int64_t> made;
    in_ledger(note_, [&] {
      for (const std::vector<std::size_t>& places : make_chunks(seconds, o_.chunk_seconds)) {
        Chunk& chunk = chunks_[++last_batch_];
        made.push_back(last_batch_);
        for (const std::size_t place : places) {
          const Job& job = jobs[place];
          queue_.slurm().add(part_of(last_batch_, static_cast<int>(chunk.items.size()), job.id, job.attempt));
          chunk.items.push_back({job.id, job.attempt, seconds[place], draw_code(job.id)});
        }
        with_slurm_ += static_cast<int>(places.size());
      }
    });
    for (const std::int64_t batch : made) {
      now_ += o_.sbatch_seconds;
      sbatch_seconds_ += o_.sbatch_seconds;
      waiting_.push_back(batch);
      advance_nodes(now_);
    }
    in_ledger(note_, [&] {
      for (const std::int64_t batch : made) queue_.slurm().set_slurm_job(batch, batch);
    });
  }

  int draw_code(std::int64_t job) {
    // The seed depends only on the map, so a map that cannot be baked fails in every attempt.
    std::minstd_rand of_map(static_cast<unsigned>(job) * 7919u + o_.seed);
    of_map.discard(3);
    if (std::uniform_real_distribution<>()(of_map) < o_.refuse_share) return 3;
    return std::uniform_real_distribution<>()(random_) < o_.fail_share ? 4 : 0;
  }

  Json a_map(const LedgerTime& time) const {
    return {{"elapsed", 1e6 * time.elapsed / o_.maps}, {"processor", 1e6 * time.processor / o_.maps}};
  }

  Json report() {
    const double spent = now_ - work_began_;
    std::sort(looks_.begin(), looks_.end());
    const auto counts = queue_.counts();
    Json states;
    for (const auto& [queue, of] : counts)
      for (const auto& [state, count] : of) states[job_state_name(state)] = count;
    return {{"maps", o_.maps},
            {"nodes", o_.nodes},
            {"jobs", o_.jobs_max},
            {"chunk_s", o_.chunk_seconds},
            {"map_s", o_.map_seconds},
            {"sbatch_s", o_.sbatch_seconds},
            {"file_s", o_.file_seconds},
            {"asks_for_each", o_.asks_for_each},
            {"states", states},
            {"hours", spent / 3600.0},
            {"busy_share", busy_seconds_ / (spent * o_.nodes)},
            {"chunks", last_batch_},
            {"failed_attempts", failures_},
            {"node_failures", node_failures_},
            {"sbatch_share", sbatch_seconds_ / spent},
            {"look_share", look_seconds_ / spent},
            {"look_median_s", looks_[looks_.size() / 2]},
            {"look_max_s", looks_.back()},
            {"ledger_share", (claim_.elapsed + note_.elapsed + end_.elapsed) / spent},
            {"ledger_processor_share", (claim_.processor + note_.processor + end_.processor) / spent},
            {"ledger_us",
             {{"submit", a_map(submit_)}, {"claim", a_map(claim_)}, {"note", a_map(note_)}, {"end", a_map(end_)}}},
            {"commits", commits_},
            {"page", page_}};
  }

  struct Event {
    double at;
    std::int64_t batch;  // 0 if the event is that a node works again
    bool is_failure;
    bool operator>(const Event& other) const { return at > other.at; }
  };
  const std::string kOwner = slurm_owner("simulated");
  // A part has three files: an end, a status and the output of its task. move_log() opens four files of a running part.
  static constexpr double kFilesAPart = 3.0, kFilesOfLog = 4.0;

  const Options& o_;
  JobQueue queue_;
  ClaimLimits limits_;
  std::mt19937_64 random_;
  int free_nodes_;
  double now_ = 0.0, work_began_ = 0.0;
  std::map<std::int64_t, Chunk> chunks_;  // chunks in Slurm's queue
  std::deque<std::int64_t> waiting_;      // chunks that wait for a node
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
  std::int64_t last_batch_ = 0, commits_ = 0;
  int with_slurm_ = 0, finished_ = 0, failures_ = 0, node_failures_ = 0, next_sample_ = 0;
  LedgerTime submit_, claim_, note_, end_;
  double sbatch_seconds_ = 0, look_seconds_ = 0, busy_seconds_ = 0;
  std::vector<double> looks_;
  Json page_ = Json::array();
};

void check(const Options& o) {
  const auto at_least = [](const char* option, double value, double least) {
    if (!(value >= least))
      throw Error(ErrorCode::kUsage, fmt::format("{} is {:g}, expected at least {:g}", option, value, least));
  };
  at_least("--maps", o.maps, 1);
  at_least("--nodes", o.nodes, 1);
  at_least("--jobs", o.jobs_max, 1);
  at_least("--map-seconds", o.map_seconds, 1e-3);
  at_least("--chunk-seconds", o.chunk_seconds, 0);
  at_least("--sbatch-seconds", o.sbatch_seconds, 0);
  at_least("--file-seconds", o.file_seconds, 0);
  at_least("--node-hours", o.node_hours, 0.1);
  if (std::filesystem::exists(o.folder + "/jobs.sqlite"))
    throw Error(ErrorCode::kInput, o.folder + ": has a jobs.sqlite, expected a folder without one");
}

int run(int argc, char** argv) {
  Options o;
  CLI::App app("Simulates many maps on many Slurm nodes with the real ledger, in virtual time.");
  app.footer("Example: multum-farm-simulation -o run.json --folder /tmp/run --maps 20000 --nodes 100");
  app.add_option("--folder", o.folder, "folder for the ledger, on the disk that is measured")->required();
  app.add_option("-o,--output", o.json, "JSON file for the results")->required();
  app.add_option("--maps", o.maps, "number of maps to bake, one job each")->capture_default_str();
  app.add_option("--nodes", o.nodes, "number of nodes; each node runs one task at a time")->capture_default_str();
  app.add_option("--jobs", o.jobs_max, "[slurm] jobs: maximum number of jobs in Slurm at a time")
      ->capture_default_str();
  app.add_option("--map-seconds", o.map_seconds, "median seconds per bake")->capture_default_str();
  app.add_option("--chunk-seconds", o.chunk_seconds, "[slurm] chunk_s")->capture_default_str();
  app.add_option("--sbatch-seconds", o.sbatch_seconds, "seconds per sbatch")->capture_default_str();
  app.add_option("--file-seconds", o.file_seconds, "seconds per access to a file of the shared folder")
      ->capture_default_str();
  app.add_option("--fail", o.fail_share, "share of attempts that fail and may be repeated")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--refuse", o.refuse_share, "share of maps that cannot be baked")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--node-hours", o.node_hours, "mean hours between two failures of a node")->capture_default_str();
  app.add_flag("--ask-for-each", o.asks_for_each, "ask for each file of each part instead of listing folders");
  app.add_option("--seed", o.seed, "seed of the random numbers")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return print_parse_error(app, error);
  }
  check(o);
  write_text_file(o.json, Simulation(o).run().dump(1) + "\n");
  return 0;
}

}  // namespace
}  // namespace multum

int main(int argc, char** argv) { return multum::run_guarded("multum-farm-simulation", multum::run, argc, argv); }
