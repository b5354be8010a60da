// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/sqlite_database.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <cerrno>

#include "host/farm/service/files/no_space.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/path_text.h"

namespace multum {

bool SqliteError::is_of_content() const {
  switch (result_ & 0xff) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_TOOBIG:
    case SQLITE_FORMAT:
    case SQLITE_ERROR:       // a function rejects a value, or a table is missing
    case SQLITE_MISMATCH:    // a type that a column cannot have
    case SQLITE_CONSTRAINT:  // a value that a column cannot have
    case SQLITE_SCHEMA: return true;
    default: return result_ == SQLITE_IOERR_SHORT_READ || result_ == SQLITE_IOERR_CORRUPTFS;
  }
}

SqliteStatement::SqliteStatement(SqliteDatabase& database, std::string_view sql) : database_(database) {
  check(sqlite3_prepare_v3(database.handle_, sql.data(), static_cast<int>(sql.size()), SQLITE_PREPARE_PERSISTENT,
                           &statement_, nullptr));
}

SqliteStatement::~SqliteStatement() { sqlite3_finalize(statement_); }

void SqliteStatement::check(int result) const {
  if (result != SQLITE_OK) database_.fail(result);
}

SqliteStatement& SqliteStatement::bind(int number, std::int64_t value) {
  check(sqlite3_bind_int64(statement_, number, value));
  return *this;
}

// Messages may quote file names that are not UTF-8. Paths are stored as texts (path_text.h).
SqliteStatement& SqliteStatement::bind(int number, std::string_view bytes) {
  const std::string text = text_of_message(bytes);
  check(sqlite3_bind_text64(statement_, number, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8));
  return *this;
}

SqliteStatement& SqliteStatement::bind(int number, std::optional<std::int64_t> value) {
  if (value) return bind(number, *value);
  check(sqlite3_bind_null(statement_, number));
  return *this;
}

SqliteStatement& SqliteStatement::bind(int number, const SqliteStatement& row, int column) {
  check(sqlite3_bind_value(statement_, number, sqlite3_column_value(row.statement_, column)));
  return *this;
}

bool SqliteStatement::step() {
  const int result = sqlite3_step(statement_);
  if (result == SQLITE_ROW) return true;
  sqlite3_reset(statement_);
  if (result != SQLITE_DONE) database_.fail(result);
  return false;
}

int SqliteStatement::run() {
  MULTUM_CHECK(!step());
  return sqlite3_changes(database_.handle_);
}

void SqliteStatement::reset() { sqlite3_reset(statement_); }

std::int64_t SqliteStatement::integer(int column) const { return sqlite3_column_int64(statement_, column); }

std::optional<std::int64_t> SqliteStatement::optional_integer(int column) const {
  if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nullopt;
  return integer(column);
}

std::optional<int> SqliteStatement::optional_int(int column) const {
  const std::optional<std::int64_t> value = optional_integer(column);
  return value ? std::optional<int>(static_cast<int>(*value)) : std::nullopt;
}

std::string SqliteStatement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return text == nullptr ? std::string()
                         : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}

bool SqliteStatement::is_text(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_TEXT; }

SqliteDatabase::SqliteDatabase(std::string path) : path_(std::move(path)) {
  const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_EXRESCODE;
  const int result = sqlite3_open_v2(path_.c_str(), &handle_, flags, nullptr);
  try {
    if (result != SQLITE_OK) fail(result);
    // Sets exclusive mode before the log is opened. This mode works without shared memory, and fails if another process
    // uses the file.
    execute(
        "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;"
        "PRAGMA foreign_keys = ON; PRAGMA trusted_schema = OFF");
    execute("BEGIN IMMEDIATE; COMMIT");  // takes the lock and creates the log now
    file_ = file_number(path_);
    log_file_ = file_number(path_ + "-wal");
    int has_moved = 0;  // whether the file was replaced before its inode was read
    sqlite3_file_control(handle_, "main", SQLITE_FCNTL_HAS_MOVED, &has_moved);
    if (has_moved != 0) throw Error(ErrorCode::kEnvironment, path_ + ": was replaced while it was being opened");
  } catch (...) {
    sqlite3_close(handle_);
    throw;
  }
}

SqliteStatement& SqliteDatabase::statement(const char* sql) {
  std::unique_ptr<SqliteStatement>& kept = statements_[sql];
  if (!kept) kept = std::make_unique<SqliteStatement>(*this, sql);
  kept->reset();
  return *kept;
}

SqliteDatabase::~SqliteDatabase() {
  statements_.clear();
  if (sqlite3_close(handle_) != SQLITE_OK) log_warning(path_, "was closed while statements were still in use");
}

void SqliteDatabase::execute(const std::string& sql) {
  const int result = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (result != SQLITE_OK) fail(result);
}

std::int64_t SqliteDatabase::last_insert_id() const { return sqlite3_last_insert_rowid(handle_); }

std::string SqliteDatabase::damage() {
  SqliteStatement check(*this, "PRAGMA quick_check(10)");
  std::string found;
  while (check.step())
    if (check.text(0) != "ok") found += (found.empty() ? "" : "; ") + check.text(0);
  return found;
}

SqliteDatabase::FileNumber SqliteDatabase::file_number(const std::string& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) == 0) return {found.st_dev, found.st_ino};
  if (errno != ENOENT && errno != ENOTDIR) fail_by_errno(path, "cannot be examined");
  return {};
}

std::string SqliteDatabase::displaced() const {
  const auto what = [](const std::string& path, const FileNumber& opened) {
    const FileNumber found = file_number(path);
    if (found == opened) return std::string();
    return fmt::format("{}: was {} while the service ran", path, found == FileNumber{} ? "removed" : "replaced");
  };
  const std::string of_file = what(path_, file_);
  return of_file.empty() ? what(path_ + "-wal", log_file_) : of_file;
}

void SqliteDatabase::look_only(const std::string& why) {
  look_only_ = why;
  if (file_number(path_) == file_) {  // only its log is gone, so the log's contents are saved
    try {
      execute("PRAGMA wal_checkpoint(FULL)");
    } catch (const Error& error) {  // a transaction is open; closing the database will empty the log
      log_verbose(error.what());
    }
  } else {  // closing would remove another file's log
    sqlite3_db_config(handle_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  }
  execute("PRAGMA query_only = ON");
}

void SqliteDatabase::check_may_change() const {
  if (is_look_only()) throw Error(ErrorCode::kEnvironment, look_only_);
}

// Returns the errno of the last failed call if it reports a lack of space, and otherwise 0. SQLite itself keeps the
// errno only for some statements, but not for COMMIT.
int SqliteDatabase::no_space_errno() const {
  if (const int error = sqlite3_system_errno(handle_); is_no_space(error)) return error;
  for (const int kind : {SQLITE_FCNTL_FILE_POINTER, SQLITE_FCNTL_JOURNAL_POINTER}) {
    sqlite3_file* file = nullptr;
    int error = 0;
    sqlite3_file_control(handle_, "main", kind, &file);
    if (file == nullptr || file->pMethods == nullptr) continue;
    file->pMethods->xFileControl(file, SQLITE_FCNTL_LAST_ERRNO, &error);
    if (is_no_space(error)) return error;
  }
  return 0;
}

bool SqliteDatabase::empty_log() {
  if (is_look_only()) return false;
  try {
    execute("PRAGMA wal_checkpoint(TRUNCATE)");
    return true;
  } catch (const Error& error) {
    log_verbose(error.what());
    return false;
  }
}

void SqliteDatabase::fail(int result) const {
  const std::string what = handle_ != nullptr ? sqlite3_errmsg(handle_) : sqlite3_errstr(result);
  switch (result & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: throw Error(ErrorCode::kEnvironment, path_ + ": is in use by another process");
    case SQLITE_NOTADB:
    case SQLITE_TOOBIG:  // the length of a value is damaged
    case SQLITE_CORRUPT:
      throw SqliteError(
          ErrorCode::kInput,
          fmt::format(
              "{}: is damaged or not a database of jobs: {}. docs/reference/service.md explains how to repair it",
              path_, what),
          result);
    case SQLITE_READONLY: check_may_change(); break;
    case SQLITE_FULL: throw NoSpaceError(ErrorCode::kEnvironment, fmt::format("{}: {}", path_, what));
    case SQLITE_IOERR:
      errno = no_space_errno();
      if (errno != 0) fail_to_write(path_, what);
      break;
    default: break;
  }
  throw SqliteError(ErrorCode::kEnvironment, fmt::format("{}: {}", path_, what), result);
}

SqliteTransaction::~SqliteTransaction() {
  if (!is_open_) return;
  try {
    database_.execute("ROLLBACK");
  } catch (const Error& error) {  // SQLite may have rolled back a failed commit already
    log_verbose(error.what());
  }
}

void SqliteTransaction::commit() {
  database_.execute("COMMIT");
  is_open_ = false;
}

SqliteSavepoint::~SqliteSavepoint() {
  if (!is_open_) return;
  try {
    database_.execute("ROLLBACK TO part; RELEASE part");
  } catch (const Error& error) {
    log_verbose(error.what());
  }
}

void SqliteSavepoint::release() {
  database_.execute("RELEASE part");
  is_open_ = false;
}

}  // namespace multum
