// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/ledger_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <set>
#include <type_traits>

#include "host/farm/service/ledger/job_fields.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

// A new field of jobs needs no new version, because its column has a default, and earlier versions of multum ignore it.
constexpr std::int64_t kSchemaVersion = 6;
constexpr std::int64_t kApplicationId = 0x6d6c746d;  // "mltm": identifies ledgers for `file` and others

// States and outcomes are stored as the numbers of their enumerations, which therefore must never be renumbered. Other
// columns of jobs (job_fields.cpp) come after these columns, because a rescue needs the same order of columns in all
// ledgers.
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

// This table exists since version 5.
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

// Since version 6, there is an index of the numbers of jobs by state, in order, for lists of one state.
constexpr const char* kListSchema = "CREATE INDEX IF NOT EXISTS jobs_listed ON jobs (state);";

// Since version 3.
constexpr const char* kKeepNeeds = R"sql(
DROP INDEX needs_of;
ALTER TABLE needs RENAME TO needs_3;
)sql";
constexpr const char* kMoveNeeds = R"sql(
INSERT INTO needs SELECT job, needs FROM needs_3;
DROP TABLE needs_3;
)sql";

std::int64_t first_integer(SqliteDatabase& database, const char* sql) {
  SqliteStatement query(database, sql);
  return query.step() ? query.integer(0) : 0;
}

// Fields of other types are needs, which are in their own table.
void read_column(const SqliteStatement& row, int column, const JobField& field, std::string& value) {
  value = field.form == JobField::Form::kPath ? path_of_text(row.text(column)) : row.text(column);
}
void read_column(const SqliteStatement& row, int column, const JobField&, std::optional<int>& value) {
  value = row.optional_int(column);
}
void read_column(const SqliteStatement& row, int column, const JobField&, std::optional<std::int64_t>& value) {
  value = row.optional_integer(column);
}
void read_column(const SqliteStatement&, int, const JobField&, std::vector<std::int64_t>&) {}
template <typename Number>
void read_column(const SqliteStatement& row, int column, const JobField&, Number& value) {
  value = static_cast<Number>(row.integer(column));
}

void bind_column(SqliteStatement& insert, int number, const JobField& field, const std::string& value) {
  insert.bind(number, field.form == JobField::Form::kPath ? text_of_path(value) : value);
}
template <typename Number>
void bind_column(SqliteStatement& insert, int number, const JobField&, const std::optional<Number>& value) {
  insert.bind(number, std::optional<std::int64_t>(value));
}
void bind_column(SqliteStatement&, int, const JobField&, const std::vector<std::int64_t>&) {}
template <typename Number>
void bind_column(SqliteStatement& insert, int number, const JobField&, Number value) {
  insert.bind(number, static_cast<std::int64_t>(value));
}

}  // namespace

const char* lost_ledger_advice() {
  return "put the ledger back, copy the readable jobs of a damaged ledger with 'multum serve --rescue', or begin a new "
         "ledger with 'multum serve --new-ledger'; see docs/reference/service.md";
}

void prepare_ledger(SqliteDatabase& database, bool may_begin) {
  const std::int64_t found = first_integer(database, "PRAGMA user_version");
  const std::int64_t application = first_integer(database, "PRAGMA application_id");
  const bool is_empty = first_integer(database, "SELECT COUNT(*) FROM sqlite_master") == 0;
  if (found == 0 ? !is_empty : application != (found < 4 ? 0 : kApplicationId))
    throw Error(ErrorCode::kInput, database.path() + ": is a database, but not a ledger of jobs");
  if (found > kSchemaVersion)
    throw Error(ErrorCode::kInput,
                fmt::format("{}: was written by a newer multum: found database version {}, expected at most {}",
                            database.path(), found, kSchemaVersion));
  if (is_empty && !may_begin)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: is empty, expected the ledger of a folder that was used before: {}", database.path(),
                            lost_ledger_advice()));
  if (found < kSchemaVersion) {
    SqliteTransaction transaction(database);
    if (found == 0) database.execute(kSchema);
    add_job_columns(database);
    // Version 1 did not store inputs, so it is unknown whether the inputs of its jobs have changed. The keys of these
    // jobs are therefore removed.
    if (found == 1) database.execute("UPDATE jobs SET key = ''");
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
  add_job_columns(database);
}

void add_job_columns(SqliteDatabase& database) {
  static const Job kNone;
  SqliteStatement known(database, "SELECT name FROM pragma_table_info('jobs')");
  std::set<std::string> names;
  while (known.step()) names.insert(known.text(0));
  for (const JobField& field : job_fields()) {
    if (!field.has_column() || names.contains(field.name)) continue;
    const char* const definition = with_field(field, kNone, [](const auto& value) {
      using Value = std::remove_cvref_t<decltype(value)>;
      if (std::is_same_v<Value, std::string>) return "TEXT NOT NULL DEFAULT ''";
      return std::is_arithmetic_v<Value> ? "INTEGER NOT NULL DEFAULT 0" : "INTEGER";
    });
    database.execute(fmt::format("ALTER TABLE jobs ADD COLUMN {} {}", field.name, definition));
  }
}

std::vector<std::string> job_columns() {
  std::vector<std::string> names;
  for (const JobField& field : job_fields())
    if (field.has_column()) names.emplace_back(field.name);
  return names;
}

std::string select_jobs(const char* rest) {
  return fmt::format("SELECT {} FROM jobs {}", fmt::join(job_columns(), ", "), rest);
}

Job job_from_row(const SqliteStatement& row) {
  Job job;
  int column = 0;
  for (const JobField& field : job_fields())
    if (field.has_column()) with_field(field, job, [&](auto& value) { read_column(row, column++, field, value); });
  return job;
}

std::int64_t insert_job(SqliteDatabase& database, const Job& job) {
  static const std::string sql = [] {
    const std::vector<std::string> names = job_columns(), marks(names.size(), "?");
    return fmt::format("INSERT INTO jobs ({}) VALUES ({})", fmt::join(names, ", "), fmt::join(marks, ", "));
  }();
  SqliteStatement& insert = database.statement(sql.c_str());
  int number = 0;
  for (const JobField& field : job_fields())
    if (field.has_column())
      with_field(field, job, [&](const auto& value) { bind_column(insert, ++number, field, value); });
  insert.bind(1, std::optional<std::int64_t>()).run();  // the first column is the number, which the ledger chooses
  return database.last_insert_id();
}

}  // namespace multum
