// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/ledger_schema.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

constexpr std::int64_t kSchemaVersion = 6;
constexpr std::int64_t kApplicationId = 0x6d6c746d;  // "mltm": what `file` and others know a ledger by

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
)sql";

constexpr const char* kNeedsSchema = R"sql(
CREATE TABLE needs (
  job INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  needs INTEGER NOT NULL,  -- kept when that job is purged: it is known to be gone
  PRIMARY KEY (job, needs)) WITHOUT ROWID;
CREATE INDEX needs_of ON needs (needs);
)sql";

constexpr const char* kFilesSchema = R"sql(
CREATE TABLE meta (
  name TEXT PRIMARY KEY NOT NULL,  -- instance: of DATA; first_number: all from it on are this ledger's
  value NOT NULL) WITHOUT ROWID;
CREATE TABLE left_overs (  -- of purged jobs: what the next sweep of DATA removes
  job INTEGER PRIMARY KEY,
  output TEXT NOT NULL,  -- '': its log alone
  identity TEXT NOT NULL);
CREATE TABLE uploads (path TEXT PRIMARY KEY NOT NULL) WITHOUT ROWID;
)sql";

// Of version 5 on.
constexpr const char* kSlurmSchema = R"sql(
CREATE TABLE slurm_parts (  -- what was sent to Slurm for running jobs, and what became of it (slurm_notes.h)
  batch INTEGER NOT NULL,
  item INTEGER NOT NULL,
  job INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
  attempt INTEGER NOT NULL,
  share TEXT NOT NULL,
  round INTEGER NOT NULL,
  slurm_job INTEGER,  -- NULL: its number is not known here
  state INTEGER NOT NULL DEFAULT 0,
  node TEXT NOT NULL DEFAULT '',
  exit_code INTEGER,
  message TEXT NOT NULL DEFAULT '',
  PRIMARY KEY (batch, item)) WITHOUT ROWID;
CREATE INDEX slurm_parts_job ON slurm_parts (job);
CREATE INDEX slurm_parts_sent ON slurm_parts (batch) WHERE state = 0;
)sql";

// Of version 6 on: numbers of jobs in a state, in order, for lists of one.
constexpr const char* kListSchema = "CREATE INDEX IF NOT EXISTS jobs_listed ON jobs (state);";

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
// From version 3.
constexpr const char* kKeepNeeds = R"sql(
DROP INDEX needs_of;
ALTER TABLE needs RENAME TO needs_3;
)sql";
constexpr const char* kMoveNeeds = R"sql(
INSERT INTO needs SELECT job, needs FROM needs_3;
DROP TABLE needs_3;
)sql";

constexpr const char* kColumns =
    "id, type, parameters, queue, label, priority, attempt_max, deadline, memory_bytes, device, output, key, inputs, "
    "state, attempt, owner, needs_left, created, not_before, started, finished, exit_code, message, reused_from";

std::int64_t first_integer(SqliteDatabase& database, const char* sql) {
  SqliteStatement query(database, sql);
  return query.step() ? query.integer(0) : 0;
}

}  // namespace

const char* lost_ledger_advice() {
  return "put the ledger back, save what can be read of a damaged one by 'multum rescue', or begin a new one by "
         "'multum "
         "serve --new-ledger'; docs/SERVICE.md says more";
}

void prepare_ledger(SqliteDatabase& database, bool may_begin) {
  const std::int64_t found = first_integer(database, "PRAGMA user_version");
  const std::int64_t application = first_integer(database, "PRAGMA application_id");
  const bool is_empty = first_integer(database, "SELECT COUNT(*) FROM sqlite_master") == 0;
  if (found == 0 ? !is_empty : application != (found < 4 ? 0 : kApplicationId))
    throw Error(ErrorCode::kInput, database.path() + ": is a database, but no ledger of jobs");
  if (found > kSchemaVersion)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: is of a newer multum: version {} of the database, this one knows {}", database.path(),
                            found, kSchemaVersion));
  if (is_empty && !may_begin)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: is empty, expected the ledger of a folder that was used before: {}", database.path(),
                            lost_ledger_advice()));
  if (found < kSchemaVersion) {
    SqliteTransaction transaction(database);
    if (found == 0) database.execute(kSchema);
    if (found == 1) database.execute(kAddInputs);
    if (found == 1 || found == 2) database.execute(kAddStopAsked);
    if (found < 4) {
      if (found != 0) database.execute(kKeepNeeds);
      database.execute(kNeedsSchema);
      if (found != 0) database.execute(kMoveNeeds);
      database.execute(kFilesSchema);
    }
    if (found < 5) database.execute(kSlurmSchema);
    database.execute(kListSchema);
    database.execute(
        fmt::format("PRAGMA user_version = {}; PRAGMA application_id = {}", kSchemaVersion, kApplicationId));
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
  job.output = path_of_text(row.text(c++));
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
