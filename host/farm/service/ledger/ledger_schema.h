// SPDX-License-Identifier: Apache-2.0
// Defines the tables of the ledger, and converts their rows to jobs.
#pragma once

#include <string>
#include <vector>

#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

/// Creates the tables of an empty database, and upgrades an earlier version. Throws Error(kInput) for a newer version,
/// and for a database that is not a ledger. Throws Error(kEnvironment) for an empty database if `may_begin` is false.
void prepare_ledger(SqliteDatabase& database, bool may_begin);
/// Adds missing columns to the table of jobs, for fields that are newer than the table.
void add_job_columns(SqliteDatabase& database);
/// Returns the advice to the user that ends messages about a lost ledger.
const char* lost_ledger_advice();

/// Columns of the table of jobs.
std::vector<std::string> job_columns();
/// Returns a SELECT of all columns that job_from_row() needs. `rest` is its text from WHERE on.
std::string select_jobs(const char* rest);
/// Returns the job without its needs, which have their own table.
Job job_from_row(const SqliteStatement& row);
/// Writes a new job without its needs. Returns its new number.
std::int64_t insert_job(SqliteDatabase& database, const Job& job);

}  // namespace multum
