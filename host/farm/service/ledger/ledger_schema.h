// SPDX-License-Identifier: Apache-2.0
// Tables of the ledger, and their rows as jobs.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

/// Makes the tables of an empty database, and brings those of an earlier version up to this one. Throws Error(kInput)
/// for a newer version, and for a database of something else; Error(kEnvironment) for an empty one that may not begin.
void prepare_ledger(SqliteDatabase& database, bool may_begin);
/// Adds the columns that the table of jobs lacks, since it was made before their fields were.
void add_job_columns(SqliteDatabase& database);
/// The end of a message: what can be done about a ledger that is lost.
const char* lost_ledger_advice();

/// Of the table of jobs.
std::vector<std::string> job_columns();
/// SELECT of all columns that job_from_row() wants; `rest`: from WHERE on.
std::string select_jobs(const char* rest);
/// But for what it needs, which is in a table of its own.
Job job_from_row(const SqliteStatement& row);
/// Writes a new job, but for what it needs. Returns the number that it is given.
std::int64_t insert_job(SqliteDatabase& database, const Job& job);

}  // namespace multum
