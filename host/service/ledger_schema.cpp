// SPDX-License-Identifier: Apache-2.0
#include "host/service/ledger_schema.h"

#include <fmt/format.h>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr std::int64_t kSchemaVersion = 3;

// States and outcomes are stored as the numbers of their enumerations, which are therefore never renumbered.
constexpr const char* kSchema = R"sql(
CREATE TABLE jobs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,  -- a number is never used again
  type TEXT NOT NULL,
  parameters TEXT NOT NULL,
  queue TEXT NOT NULL,
  label TEXT NOT NULL,
  priority INTEGER NOT NULL,
  attempt_max INTEGER NOT NULL,
  deadline INTEGER,
  memory_bytes INTEGER NOT NULL,
  device TEXT NOT NULL,
  output TEXT NOT NULL,
  key TEXT NOT NULL,
  inputs TEXT NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 0 AND 6),
  attempt INTEGER NOT NULL DEFAULT 0,
  attempts_counted INTEGER NOT NULL DEFAULT 0,  -- against attempt_max
  owner TEXT NOT NULL DEFAULT '',
  needs_left INTEGER NOT NULL,
  created INTEGER NOT NULL,
  not_before INTEGER,
  started INTEGER,
  finished INTEGER,
  exit_code INTEGER,
  message TEXT NOT NULL DEFAULT '',
  reused_from INTEGER,
  result_identity TEXT NOT NULL DEFAULT '',
  stop_asked TEXT NOT NULL DEFAULT '');  -- why it is to be cancelled as soon as its attempt ends without a result
CREATE INDEX jobs_next ON jobs (queue, state, priority DESC, id);
CREATE INDEX jobs_state ON jobs (state, finished);
CREATE INDEX jobs_key ON jobs (key, id) WHERE key <> '';
CREATE INDEX jobs_deadline ON jobs (deadline) WHERE deadline IS NOT NULL AND state < 4;
CREATE INDEX jobs_back_off ON jobs (not_before) WHERE not_before IS NOT NULL AND state = 1;
CREATE TABLE needs (
  job INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  needs INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  PRIMARY KEY (job, needs)) WITHOUT ROWID;
CREATE INDEX needs_of ON needs (needs);
CREATE TABLE attempts (
  job INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  owner TEXT NOT NULL,
  outcome INTEGER NOT NULL,
  started INTEGER NOT NULL,
  ended INTEGER,
  exit_code INTEGER,
  message TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (job, number)) WITHOUT ROWID;
PRAGMA user_version = 3;
)sql";

// From versions 1 and 2, of multum 0.1 before its release.
constexpr const char* kAddInputs = R"sql(
ALTER TABLE jobs ADD COLUMN inputs TEXT NOT NULL DEFAULT '';
UPDATE jobs SET key = '';  -- whether inputs are still what they were cannot be known
PRAGMA user_version = 2;
)sql";
constexpr const char* kAddStopAsked = R"sql(
ALTER TABLE jobs ADD COLUMN stop_asked TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 3;
)sql";

constexpr const char* kColumns =
    "id, type, parameters, queue, label, priority, attempt_max, deadline, memory_bytes, device, output, key, inputs, "
    "state, attempt, owner, needs_left, created, not_before, started, finished, exit_code, message, reused_from";

}  // namespace

void prepare_ledger(SqliteDatabase& database) {
  SqliteStatement version(database, "PRAGMA user_version");
  version.step();
  const std::int64_t found = version.integer(0);
  version.reset();
  if (found > kSchemaVersion)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: is of a newer multum: version {} of the database, this one knows {}", database.path(),
                            found, kSchemaVersion));
  if (found < kSchemaVersion) {
    SqliteTransaction transaction(database);
    if (found == 0) database.execute(kSchema);
    if (found == 1) database.execute(kAddInputs);
    if (found == 1 || found == 2) database.execute(kAddStopAsked);
    transaction.commit();
  }
}

std::string select_jobs(const char* rest) { return fmt::format("SELECT {} FROM jobs {}", kColumns, rest); }

Job job_from_row(const SqliteStatement& row) {
  Job job;
  int c = 0;
  job.id = row.integer(c++);
  job.type = row.text(c++);
  job.parameters = row.text(c++);
  job.queue = row.text(c++);
  job.label = row.text(c++);
  job.priority = static_cast<int>(row.integer(c++));
  job.attempt_max = static_cast<int>(row.integer(c++));
  job.deadline = row.optional_integer(c++);
  job.memory_bytes = row.integer(c++);
  job.device = row.text(c++);
  job.output = row.text(c++);
  job.key = row.text(c++);
  job.inputs = row.text(c++);
  job.state = static_cast<JobState>(row.integer(c++));
  job.attempt = static_cast<int>(row.integer(c++));
  job.owner = row.text(c++);
  job.needs_left = static_cast<int>(row.integer(c++));
  job.created = row.integer(c++);
  job.not_before = row.optional_integer(c++);
  job.started = row.optional_integer(c++);
  job.finished = row.optional_integer(c++);
  job.exit_code = row.optional_int(c++);
  job.message = row.text(c++);
  job.reused_from = row.optional_integer(c++);
  return job;
}

}  // namespace multum
