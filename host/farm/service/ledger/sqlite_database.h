// SPDX-License-Identifier: Apache-2.0
// Wraps SQLite and turns its errors into exceptions. Only this code includes the header of SQLite. A database must not
// be used by two threads at the same time.
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

/// An error that SQLite reports for a statement or for the data that it reads. No other exception is thrown for damaged
/// files.
class SqliteError : public Error {
 public:
  SqliteError(ErrorCode code, const std::string& message, int result) : Error(code, message), result_(result) {}
  /// Returns whether the file's contents may be the cause, which are then damaged or have values that no ledger has.
  /// Otherwise the cause is the disk or memory.
  bool is_of_content() const;

 private:
  int result_;  // an extended result code of SQLite
};

/// A statement that is prepared once and run often. The caller binds all values, and then calls run(), or calls step()
/// until it returns false.
class SqliteStatement {
 public:
  SqliteStatement(SqliteDatabase& database, std::string_view sql);
  ~SqliteStatement();
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;

  /// Binds the `?` with this number, counted from 1. Copies texts and stores them as UTF-8 (text_of_message()).
  SqliteStatement& bind(int number, std::int64_t value);
  SqliteStatement& bind(int number, int value) { return bind(number, static_cast<std::int64_t>(value)); }
  SqliteStatement& bind(int number, std::string_view text);
  SqliteStatement& bind(int number, const char* text) { return bind(number, std::string_view(text)); }
  SqliteStatement& bind(int number, std::optional<std::int64_t> value);

  /// Binds a column of another database's row.
  SqliteStatement& bind(int number, const SqliteStatement& row, int column);

  /// Moves to the next row. Returns false after the last row, and then values may be bound again.
  bool step();
  /// Runs a statement without rows. Returns the number of changed rows.
  int run();
  void reset();

  /// The columns of the current row of step(), counted from 0.
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
  /// Opens or creates the file and locks it for this process. Uses a write-ahead log, foreign keys, and synchronous
  /// FULL, so that commits survive a power cut. Throws Error(kEnvironment) if another process has locked the file, or
  /// for disk errors. Throws Error(kInput) if it is damaged or not a database.
  explicit SqliteDatabase(std::string path);
  ~SqliteDatabase();
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  /// Runs one or more statements without results.
  void execute(const std::string& sql);
  /// Returns a statement that stays prepared, ready for binding. Statements are found by the address of `sql`, which
  /// must be a literal or a static text.
  SqliteStatement& statement(const char* sql);
  std::int64_t last_insert_id() const;
  /// Moves committed data from the log to the file, so that the log needs no more space. Must not be called within a
  /// transaction. Returns false if there is no room for this move either.
  bool empty_log();
  /// Returns the findings of `PRAGMA quick_check`, or an empty list if there are none.
  std::string damage();
  const std::string& path() const { return path_; }

  /// Returns the reason if commits would be lost because the file or its log was removed or replaced. Returns an empty
  /// text if both are in place. Takes two calls of stat(). Throws Error(kEnvironment) when this cannot be determined.
  std::string displaced() const;
  /// Makes the database read-only. Changes then throw Error(kEnvironment, why).
  void look_only(const std::string& why);
  bool is_look_only() const { return !look_only_.empty(); }
  /// Throws if a change would throw.
  void check_may_change() const;

 private:
  friend class SqliteStatement;
  struct FileNumber {
    std::uint64_t device = 0, inode = 0;  // 0 if there is no file
    bool operator==(const FileNumber&) const = default;
  };
  static FileNumber file_number(const std::string& path);
  [[noreturn]] void fail(int result) const;
  int no_space_errno() const;
  std::string path_;
  sqlite3* handle_ = nullptr;
  FileNumber file_, log_file_;  // the files when they were opened
  std::string look_only_;       // the reason for read-only mode; empty if changes are allowed
  std::map<const char*, std::unique_ptr<SqliteStatement>> statements_;
};

/// A transaction, which makes either all changes up to commit() or none. The destructor undoes the changes if commit()
/// was not called.
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

/// A transaction within a transaction. If it fails, only its own changes are undone.
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
