// SPDX-License-Identifier: Apache-2.0
// SQLite with errors as exceptions: the only code that includes its header. One thread uses a database at a time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/foundation/base/error.h"

struct sqlite3;
struct sqlite3_stmt;

namespace multum {

class SqliteDatabase;

/// An error that SQLite has for a statement or for what it reads. No other is thrown for damage in a file.
class SqliteError : public Error {
 public:
  SqliteError(ErrorCode code, const std::string& message, int result) : Error(code, message), result_(result) {}
  /// Can what is in the file be the reason: it is damaged, or holds what no ledger does? Else it is the disk, or
  /// memory.
  bool is_of_content() const;

 private:
  int result_;  // of SQLite, an extended code
};

/// A statement that is prepared once and run often: bind everything, then step() until it is false, or run().
class SqliteStatement {
 public:
  SqliteStatement(SqliteDatabase& database, std::string_view sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  /// Numbers of `?` from 1. A text is copied, and is UTF-8 in the database: as text_of_message() has it.
  SqliteStatement& bind(int number, std::int64_t value);
  SqliteStatement& bind(int number, int value) { return bind(number, static_cast<std::int64_t>(value)); }
  SqliteStatement& bind(int number, std::string_view text);
  SqliteStatement& bind(int number, const char* text) { return bind(number, std::string_view(text)); }
  SqliteStatement& bind(int number, std::optional<std::int64_t> value);

  /// A column of another database's row.
  SqliteStatement& bind(int number, const SqliteStatement& row, int column);

  /// The next row, false after the last: then it may be bound anew.
  bool step();
  /// Runs a statement without rows. Returns how many rows it changed.
  int run();
  void reset();

  /// Columns from 0, of the row that step() has reached.
  std::int64_t integer(int column) const;
  std::optional<std::int64_t> optional_integer(int column) const;
  std::optional<int> optional_int(int column) const;
  std::string text(int column) const;
  bool is_text(int column) const;

 private:
  void check(int result) const;
  SqliteDatabase& database_;
  sqlite3_stmt* statement_ = nullptr;
};

class SqliteDatabase {
 public:
  /// Opens or creates the file: write-ahead log, synchronous FULL (what is committed outlives a power cut), foreign
  /// keys, locked for this process alone. Throws Error(kEnvironment): another process has it, the disk; Error(kInput):
  /// not a database, or a damaged one.
  explicit SqliteDatabase(std::string path);
  ~SqliteDatabase();
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  /// One or more statements without results.
  void execute(const std::string& sql);
  /// A statement that stays prepared, ready to be bound. `sql` is known by its address: a literal, or a static text.
  SqliteStatement& statement(const char* sql);
  std::int64_t last_insert_id() const;
  /// Moves what is committed from the log to the file, so that the log needs no more space. Not within a transaction.
  /// False: there is no room for that either.
  bool empty_log();
  /// Findings of `PRAGMA quick_check`; empty when all is well.
  std::string damage();
  const std::string& path() const { return path_; }

  /// Why what is committed would be lost: another file or none is at its path, or at its log's; empty: all is in place.
  /// Two calls of stat(). Throws Error(kEnvironment) when that cannot be known.
  std::string displaced() const;
  /// Makes the database read-only: what would change it throws Error(kEnvironment, why).
  void look_only(const std::string& why);
  bool is_look_only() const { return !look_only_.empty(); }
  /// Throws as a change would.
  void check_may_change() const;

 private:
  friend class SqliteStatement;
  struct FileNumber {
    std::uint64_t device = 0, inode = 0;  // of no file: 0
    bool operator==(const FileNumber&) const = default;
  };
  static FileNumber file_number(const std::string& path);
  [[noreturn]] void fail(int result) const;
  int no_space_errno() const;
  std::string path_;
  sqlite3* handle_ = nullptr;
  FileNumber file_, log_file_;  // as they were opened
  std::string look_only_;       // why; empty: it may be changed
  std::map<const char*, std::unique_ptr<SqliteStatement>> statements_;
};

/// Transaction: everything until commit() is done wholly or not at all, and undone when it goes out of scope before.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteDatabase& database) : database_(database) {
    database_.execute(database_.is_look_only() ? "BEGIN" : "BEGIN IMMEDIATE");
  }
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;
  void commit();

 private:
  SqliteDatabase& database_;
  bool is_open_ = true;
};

/// Transaction within a transaction: what fails is undone alone.
class SqliteSavepoint {
 public:
  explicit SqliteSavepoint(SqliteDatabase& database) : database_(database) { database_.execute("SAVEPOINT part"); }
  ~SqliteSavepoint();
  SqliteSavepoint(const SqliteSavepoint&) = delete;
  SqliteSavepoint& operator=(const SqliteSavepoint&) = delete;
  void release();

 private:
  SqliteDatabase& database_;
  bool is_open_ = true;
};

}  // namespace multum
