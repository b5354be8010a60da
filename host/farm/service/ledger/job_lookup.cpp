// SPDX-License-Identifier: Apache-2.0
// Reads single jobs, lists, counts and numbers from the ledger. Changes nothing.
#include <fmt/format.h>

#include <algorithm>

#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/ledger/ledger_schema.h"

namespace multum {

std::optional<Job> JobQueue::find(std::int64_t id) {
  static const std::string sql = select_jobs("WHERE id = ?");
  SqliteStatement& query = statement(sql.c_str());
  query.bind(1, id);
  if (!query.step()) return std::nullopt;
  Job job = job_from_row(query);
  query.reset();
  job.needs = needs_of(id);
  return job;
}

std::vector<std::int64_t> JobQueue::needs_of(std::int64_t id) {
  SqliteStatement& needs = statement("SELECT needs FROM needs WHERE job = ? ORDER BY needs");
  needs.bind(1, id);
  return ids(needs);
}

namespace {

// The parameters are ?1 state, ?2 queue, ?3 before, and ?4 limit. Each query reads rows in the order of an index and
// stops at the limit. Only the query by queue and state reads the numbers of all matching jobs, which are also in an
// index.
constexpr char kOfAll[] =
    "WHERE (?2 = '' OR queue = ?2) AND id < IFNULL(?3, 9223372036854775807) ORDER BY id DESC LIMIT ?4";
constexpr char kOfState[] =
    "INDEXED BY jobs_listed WHERE state = ?1 AND ?2 = '' AND id < IFNULL(?3, 9223372036854775807) ORDER BY id DESC "
    "LIMIT ?4";
constexpr char kOfQueueAndState[] =
    "WHERE id IN (SELECT id FROM jobs INDEXED BY jobs_next WHERE queue = ?2 AND state = ?1 AND id < IFNULL(?3, "
    "9223372036854775807) ORDER BY id DESC LIMIT ?4) ORDER BY id DESC";

// One query for each kind of filter. `text` makes a query from its conditions.
struct FilteredQueries {
  template <typename Text>
  explicit FilteredQueries(const Text& text)
      : all(text(kOfAll)), of_state(text(kOfState)), of_queue_and_state(text(kOfQueueAndState)) {}

  const char* of(const JobFilter& filter) const {
    return (!filter.state ? all : filter.queue.empty() ? of_state : of_queue_and_state).c_str();
  }

  std::string all, of_state, of_queue_and_state;
};

}  // namespace

SqliteStatement& JobQueue::bind_filter(SqliteStatement& query, const JobFilter& filter) {
  query.bind(1, filter.state ? std::optional<std::int64_t>(static_cast<int>(*filter.state)) : std::nullopt);
  return query.bind(2, filter.queue).bind(3, filter.before).bind(4, std::clamp(filter.limit, 1, 1000));
}

std::vector<Job> JobQueue::list(const JobFilter& filter) {
  static const FilteredQueries sql(select_jobs);
  SqliteStatement& query = bind_filter(statement(sql.of(filter)), filter);
  std::vector<Job> jobs;
  while (query.step()) jobs.push_back(job_from_row(query));
  for (Job& job : jobs) job.needs = needs_of(job.id);
  return jobs;
}

std::int64_t JobQueue::list_bytes(const JobFilter& filter) {
  // Casts texts to blobs, because the length of a text is its number of characters, for which SQLite must read the
  // whole text. Adds 10 bytes per need, and 500 bytes for a job's names and times.
  static const FilteredQueries sql([](const char* conditions) {
    std::string bytes = "500 + 10 * (SELECT COUNT(*) FROM needs WHERE needs.job = jobs.id)";
    for (const JobField& field : job_fields())
      if (std::holds_alternative<std::string Job::*>(field.member))
        bytes += fmt::format(" + length(CAST({} AS BLOB))", field.name);
    return fmt::format("SELECT IFNULL(SUM(bytes), 0) FROM (SELECT {} AS bytes FROM jobs {})", bytes, conditions);
  });
  SqliteStatement& query = bind_filter(statement(sql.of(filter)), filter);
  query.step();
  const std::int64_t bytes = query.integer(0);
  query.reset();
  return bytes;
}

std::vector<JobAttempt> JobQueue::attempts(std::int64_t id) {
  SqliteStatement& query = statement(
      "SELECT number, owner, outcome, started, ended, exit_code, message FROM attempts WHERE job = ? ORDER BY number");
  query.bind(1, id);
  std::vector<JobAttempt> attempts;
  while (query.step())
    attempts.push_back({static_cast<int>(query.integer(0)), query.text(1),
                        static_cast<AttemptOutcome>(query.integer(2)), query.integer(3), query.optional_integer(4),
                        query.optional_int(5), query.text(6)});
  return attempts;
}

std::map<std::string, std::map<JobState, std::int64_t>> JobQueue::counts() {
  SqliteStatement& query = statement("SELECT queue, state, COUNT(*) FROM jobs GROUP BY queue, state");
  std::map<std::string, std::map<JobState, std::int64_t>> counts;
  while (query.step()) counts[query.text(0)][static_cast<JobState>(query.integer(1))] = query.integer(2);
  return counts;
}

std::vector<Job> JobQueue::succeeded_with_key(const std::string& key) {
  static const std::string sql = select_jobs("WHERE key = ? AND key <> '' AND state = 4 ORDER BY id DESC LIMIT 10");
  SqliteStatement& query = statement(sql.c_str());
  query.bind(1, key);
  std::vector<Job> jobs;
  while (query.step()) jobs.push_back(job_from_row(query));
  return jobs;
}

bool JobQueue::Numbers::is_finished_with(std::int64_t id) const {
  if (std::binary_search(ended.begin(), ended.end(), id)) return true;
  return given.has(id) && !std::binary_search(unfinished.begin(), unfinished.end(), id);
}

JobQueue::Numbers JobQueue::numbers() {
  Numbers found;
  found.ended = ids(statement("SELECT id FROM jobs WHERE state >= 4 ORDER BY id"));
  found.unfinished = ids(statement("SELECT id FROM jobs WHERE state < 4 ORDER BY id"));
  found.given = given();
  return found;
}

JobQueue::Given JobQueue::given() {
  SqliteStatement& range = statement(
      "SELECT IFNULL((SELECT value FROM meta WHERE name = 'first_number'), 1), IFNULL((SELECT seq FROM sqlite_sequence "
      "WHERE name = 'jobs'), 0)");
  range.step();
  const Given found = {range.integer(0), range.integer(1)};
  range.reset();
  return found;
}

bool JobQueue::was_purged(std::int64_t id) { return given().has(id) && !find(id); }

}  // namespace multum
