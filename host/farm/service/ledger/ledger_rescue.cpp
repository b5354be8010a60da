// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/ledger_rescue.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "host/farm/service/files/data_lock.h"
#include "host/farm/service/files/job_numbers.h"
#include "host/farm/service/ledger/job_fields.h"
#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/ledger/ledger_schema.h"
#include "host/farm/service/ledger/ledger_start.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Ids = std::set<std::int64_t>;

// A table whose rows are found by a number. `is_whole` is a condition that rows with damaged columns do not meet.
struct RescuedTable {
  const char* name;
  const char* number;
  std::vector<std::string> columns;
  std::string is_whole;
};

// Requires each of a job's columns to have its type and to be within its limits.
std::string is_whole_job() {
  std::string text = "(state < 4) = (finished IS NULL)";
  for (const JobField& field : job_fields()) {
    const bool is_text = std::holds_alternative<std::string Job::*>(field.member),
               may_lack = std::holds_alternative<std::optional<int> Job::*>(field.member) ||
                          std::holds_alternative<std::optional<std::int64_t> Job::*>(field.member);
    if (!field.has_column()) continue;
    text += fmt::format(" AND typeof({}) IN ({})", field.name,
                        is_text    ? "'text'"
                        : may_lack ? "'integer', 'null'"
                                   : "'integer'");
    if (field.is_number()) text += fmt::format(" AND {} BETWEEN {} AND {}", field.name, field.low, field.high);
    if (field.form == JobField::Form::kObject)
      text += fmt::format(" AND CASE WHEN json_valid({0}) THEN json_type({0}) = 'object' ELSE 0 END", field.name);
  }
  return text;
}

const RescuedTable kJobs = {"jobs", "id", job_columns(), is_whole_job()};
const RescuedTable kAttempts = {
    "attempts",
    "job",
    {"job", "number", "owner", "outcome", "started", "ended", "exit_code", "message"},
    "number BETWEEN 1 AND 1000000000 AND outcome BETWEEN 0 AND 6 AND typeof(owner) = 'text' AND typeof(started) = "
    "'integer' AND typeof(ended) IN ('integer', 'null') AND typeof(message) = 'text'"};
const RescuedTable kNeeds = {"needs", "job", {"job", "needs"}, "typeof(needs) = 'integer' AND needs < job"};
// If the list of tables is copied from another ledger, this table's place may contain another table that also has pairs
// of small numbers. Therefore each pair must also be in the index.
const RescuedTable kNeedsByIndex = {
    "needs",
    "job",
    {"job", "needs"},
    "needs < job AND EXISTS (SELECT 1 FROM needs AS other INDEXED BY needs_of WHERE other.needs = needs.needs AND "
    "other.job = needs.job)"};
const RescuedTable kLeftOvers = {
    "left_overs", "job", {"job", "output", "identity"}, "typeof(output) = 'text' AND typeof(identity) = 'text'"};

bool is_text(const std::string& text) {
  try {
    (void)nlohmann::json(text).dump();  // the web interface does the same
    return true;
  } catch (const nlohmann::json::exception&) {
    return false;
  }
}

// Runs `read`, and returns false if the data are damaged.
template <typename Read>
bool reads(Read read) {
  try {
    read();
    return true;
  } catch (const SqliteError& error) {
    if (!error.is_of_content()) throw;
    return false;
  }
}

class Rescue {
 public:
  Rescue(SqliteDatabase& old, SqliteDatabase& ledger, std::int64_t highest)
      : old_(old), ledger_(ledger), highest_(highest) {}

  std::vector<RescueReport::Table> run(bool is_list_lent) {
    SqliteTransaction transaction(ledger_);
    reads([&] {
      SqliteStatement last(old_, "SELECT seq FROM sqlite_sequence WHERE name = 'jobs'");
      if (last.step() && last.integer(0) < kHighest) highest_ = std::max(highest_, last.integer(0));
    });
    const Ids jobs = copy(kJobs, numbers_of(kJobs));
    copy(kAttempts, jobs);
    copy(is_list_lent ? kNeedsByIndex : kNeeds, jobs);
    if (has_table("left_overs")) copy(kLeftOvers, numbers_of(kLeftOvers));
    if (has_table("uploads")) copy_uploads();
    make_consistent();
    transaction.commit();
    return std::move(tables_);
  }

  std::int64_t highest() const { return highest_; }
  /// Returns whether no damage was found.
  bool is_whole() const { return is_whole_; }

 private:
  static constexpr std::int64_t kHighest = std::int64_t{1} << 52;
  static constexpr std::int64_t kProbesMax = 2000000;  // numbers to try between two readable parts, which takes seconds

  bool has_table(const char* name) {  // tables exist from version 4 on
    bool is_there = false;
    reads([&] {
      SqliteStatement query(old_, "SELECT 1 FROM sqlite_master WHERE name = ?");
      is_there = query.bind(1, name).step();
    });
    return is_there;
  }

  // Returns the numbers of all possible rows. These are the numbers of the readable rows at both ends, up to a damaged
  // row, and all numbers in between.
  Ids numbers_of(const RescuedTable& table) {
    Ids numbers;
    const auto scan = [&](const char* order) {
      std::int64_t reached = 0;
      const bool is_whole = reads([&] {
        SqliteStatement rows(
            old_, fmt::format("SELECT {0} FROM {1} WHERE {0} > 0 ORDER BY {0} {2}", table.number, table.name, order));
        while (rows.step()) {
          reached = rows.integer(0);
          if (reached < kHighest) numbers.insert(reached);
        }
      });
      return std::pair(is_whole, reached);
    };
    const auto [is_whole, first_reached] = scan("ASC");
    if (is_whole) return numbers;
    is_whole_ = false;
    const std::int64_t last_reached = scan("DESC").second;
    const std::int64_t end = last_reached > 0 ? last_reached : highest_ + 1;
    for (std::int64_t id = first_reached + 1; id < std::min(end, first_reached + kProbesMax); ++id) numbers.insert(id);
    return numbers;
  }

  // Copies the rows with these numbers, and returns the numbers of saved rows.
  Ids copy(const RescuedTable& table, const Ids& numbers) {
    RescueReport::Table& report = tables_.emplace_back();
    report.name = table.name;
    const std::string names = fmt::format("{}", fmt::join(table.columns, ", "));
    const std::vector<std::string> marks(table.columns.size(), "?");
    Ids saved;
    const bool is_known = reads([&] {
      SqliteStatement rows(
          old_, fmt::format("SELECT {}, ({}) FROM {} WHERE {} = ?", names, table.is_whole, table.name, table.number));
      SqliteStatement insert(
          ledger_, fmt::format("INSERT OR IGNORE INTO {} ({}) VALUES ({})", table.name, names, fmt::join(marks, ", ")));
      for (const std::int64_t number : numbers) {
        const bool is_read = reads([&] {
          rows.reset();
          rows.bind(1, number);
          while (rows.step()) {
            const bool is_saved = copy_row(table, rows, insert);
            ++(is_saved ? report.saved : report.damaged);
            if (is_saved) saved.insert(number);
          }
        });
        if (!is_read) ++report.damaged;
      }
    });
    is_whole_ = is_whole_ && is_known && report.damaged == 0;
    return saved;
  }

  // Returns false if the row is damaged, or the ledger does not accept it.
  static bool copy_row(const RescuedTable& table, const SqliteStatement& row, SqliteStatement& insert) {
    if (row.integer(static_cast<int>(table.columns.size())) != 1) return false;
    bool is_inserted = false;
    const bool is_taken = reads([&] {
      insert.reset();
      for (int c = 0; c < static_cast<int>(table.columns.size()); ++c) {
        // A message may quote a name that is not UTF-8, stored by an earlier version.
        const bool is_message = table.columns[static_cast<std::size_t>(c)] == "message";
        if (row.is_text(c) && !is_message && !is_text(row.text(c))) return;
        if (row.is_text(c)) insert.bind(c + 1, row.text(c));
        else insert.bind(c + 1, row, c);
      }
      is_inserted = insert.run() > 0;
    });
    return is_taken && is_inserted;
  }

  void copy_uploads() {
    RescueReport::Table& report = tables_.emplace_back();
    report.name = "uploads";
    for (const char* order : {"ASC", "DESC"}) {
      const bool is_whole = reads([&] {
        SqliteStatement rows(old_, fmt::format("SELECT path FROM uploads ORDER BY path {}", order));
        SqliteStatement insert(ledger_, "INSERT OR IGNORE INTO uploads (path) VALUES (?)");
        while (rows.step()) {
          const std::string path = rows.text(0);
          if (!rows.is_text(0) || !is_text(path)) ++report.damaged;
          else report.saved += insert.bind(1, path).run();
        }
      });
      if (is_whole) return;
      is_whole_ = false;
    }
    ++report.damaged;
  }

  // Restores the invariants of an undamaged ledger.
  void make_consistent() {
    ledger_.execute(
        "UPDATE jobs SET attempt = MAX(attempt, IFNULL((SELECT MAX(number) FROM attempts WHERE job = id), 0))");
    SqliteStatement lost_needs(
        ledger_,
        "UPDATE jobs SET state = 5, finished = ?, message = 'a job that it needs was lost with a damaged ledger' WHERE "
        "state = 0 AND needs_left > (SELECT COUNT(*) FROM needs LEFT JOIN jobs AS other ON other.id = needs.needs "
        "WHERE needs.job = jobs.id AND other.state IS NOT 4)");
    lost_needs.bind(1, wall_clock_ms()).run();
    SqliteStatement last(ledger_, "SELECT IFNULL(MAX(id), 0) FROM jobs");
    last.step();
    highest_ = std::max(highest_, last.integer(0));
    last.reset();
    // Unknown jobs with smaller numbers were lost, not purged.
    ledger_.execute(fmt::format("INSERT OR REPLACE INTO meta (name, value) VALUES ('first_number', {})", highest_ + 1));
  }

  SqliteDatabase& old_;
  SqliteDatabase& ledger_;
  std::int64_t highest_;  // highest possible number of a job
  std::vector<RescueReport::Table> tables_;
  bool is_whole_ = true;
};

void remove_database(const std::string& path) {
  std::error_code ignored;
  for (const char* part : {"", "-wal", "-shm", "-journal"}) fs::remove(path + part, ignored);
}

void copy_database(const std::string& from, const std::string& to) {
  remove_database(to);
  for (const char* part : {"", "-wal"}) {
    std::error_code error;
    if (*part != '\0' && !fs::exists(from + part, error)) continue;
    fs::copy_file(from + part, to + part, error);
    if (error)
      throw Error(ErrorCode::kEnvironment,
                  fmt::format("{}{}: cannot be copied to {}{}: {}", from, part, to, part, error.message()));
  }
}

// Removes a rescue's temporary files, however the rescue ends.
struct Scaffold {
  std::string copy, fresh;
  ~Scaffold() {
    remove_database(copy);
    remove_database(fresh);
  }
};

bool has_tables(const std::string& path) {
  return reads([&] {
    SqliteDatabase database(path);
    for (const RescuedTable* table : {&kJobs, &kAttempts, &kNeeds})
      SqliteStatement(database, fmt::format("SELECT {} FROM {}", table->number, table->name));
  });
}

constexpr std::size_t kPageBytes = 4096;
using Page = std::array<char, kPageBytes>;

std::uint32_t big_endian(const Page& page, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | static_cast<unsigned char>(page[at + i]);
  return value;
}

void set_big_endian(Page& page, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) page[at + i] = static_cast<char>(value >> (24 - 8 * i));
}

// Copies the list of tables from a new ledger: page 1, and the pages below it if any (sqlite.org/fileformat2.html):
//   28 pages of the file | 32 first free page | 36 count of these | 100 kind: 5 has pages below it | 103 count of cells
//   | 108 last page below | 112 where each cell begins: with the number of a page below
void lend_table_list(const std::string& from, const std::string& to) {
  std::ifstream in(from, std::ios::binary);
  std::fstream out(to, std::ios::binary | std::ios::in | std::ios::out);
  const auto page_number = [](std::uint32_t number) { return static_cast<std::streamoff>((number - 1) * kPageBytes); };
  const auto read = [&](std::uint32_t number) {
    Page page{};
    in.seekg(page_number(number)).read(page.data(), kPageBytes);
    return page;
  };
  Page first = read(1);
  std::vector<std::uint32_t> below;
  if (first[100] == 5) {
    for (std::uint32_t i = 0; i < big_endian(first, 103, 2); ++i)
      below.push_back(big_endian(first, big_endian(first, 112 + 2 * i, 2), 4));
    below.push_back(big_endian(first, 108, 4));
  }
  for (const std::uint32_t number : below) out.seekp(page_number(number)).write(read(number).data(), kPageBytes);
  set_big_endian(first, 28, static_cast<std::uint32_t>(fs::file_size(to) / kPageBytes));
  set_big_endian(first, 32, 0);
  set_big_endian(first, 36, 0);
  out.seekp(0).write(first.data(), kPageBytes);
  if (!in || !out.flush()) throw Error(ErrorCode::kEnvironment, to + ": cannot be written");
}

std::string free_name(const std::string& path) {
  for (int number = 1;; ++number)
    if (std::string name = fmt::format("{}.damaged-{}", path, number); !fs::exists(name)) return name;
}

}  // namespace

namespace {

struct Rescued {
  std::vector<RescueReport::Table> tables;
  bool is_whole = false;
  std::int64_t jobs() const { return tables.empty() ? 0 : tables.front().saved; }
};

// Rescues `copy` into a new ledger, `settings.path`.
Rescued rescue_copy(const LedgerSettings& settings, const std::string& copy, const std::string& data,
                    bool is_list_lent) {
  remove_database(settings.path);
  { const JobQueue made(settings); }
  Rescued rescued;
  if (is_list_lent) lend_table_list(settings.path, copy);
  JobQueue ledger(settings);
  reads([&] {
    SqliteDatabase old(copy);
    old.execute("PRAGMA cell_size_check = ON");
    reads([&] { add_job_columns(old); });
    Rescue rescue(old, ledger.database(), highest_job_number(data));
    rescued.tables = rescue.run(is_list_lent);
    rescued.is_whole = rescue.is_whole() && !is_list_lent;
    ledger.number_above(rescue.highest());
  });
  return rescued;
}

// Renames the old ledger, and gives its name to the new ledger.
std::string take_place(const std::string& path, const std::string& fresh) {
  const std::string kept = free_name(path);
  std::error_code error;
  if (fs::exists(fresh + "-wal", error))  // the contents of the log would be lost
    throw Error(ErrorCode::kEnvironment, fresh + ": cannot be completed; is the disk full?");
  fs::rename(path, kept, error);
  if (error)
    throw Error(ErrorCode::kEnvironment, fmt::format("{}: cannot be renamed to {}: {}", path, kept, error.message()));
  if (fs::exists(path + "-wal", error)) fs::rename(path + "-wal", kept + "-wal", error);
  if (!error) fs::rename(fresh, path, error);
  if (!error) return kept;
  const std::string why = error.message();
  if (fs::exists(kept + "-wal", error)) fs::rename(kept + "-wal", path + "-wal", error);
  fs::rename(kept, path, error);
  throw Error(ErrorCode::kEnvironment, fmt::format("{}: the rescued ledger cannot replace it: {}", path, why));
}

}  // namespace

RescueReport rescue_ledger(const std::string& data) {
  const std::string path = data + "/jobs.sqlite";
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw Error(ErrorCode::kInput, path + ": is missing, expected a ledger to rescue");
  const std::unique_ptr<DataLock> lock = DataLock::take(data);
  if (!lock) throw Error(ErrorCode::kEnvironment, data + ": a daemon is running there, and must be stopped first");
  if (fs::file_size(path, error) == 0 && !fs::exists(path + "-wal", error))
    throw Error(ErrorCode::kInput, path +
                                       ": is empty, so there is nothing to rescue; move it away, and start once "
                                       "with 'multum serve --new-ledger'");
  // Works on a copy, because opening a database writes to it.
  const Scaffold scaffold{path + ".copy", path + ".rescued"};
  LedgerSettings settings;
  settings.path = scaffold.fresh;
  settings.instance = read_instance(data);
  Rescued rescued;
  copy_database(path, scaffold.copy);
  if (has_tables(scaffold.copy)) rescued = rescue_copy(settings, scaffold.copy, data, false);
  if (rescued.jobs() == 0 && !rescued.is_whole) {
    copy_database(path, scaffold.copy);
    rescued = rescue_copy(settings, scaffold.copy, data, true);
  }
  if (rescued.jobs() == 0 && !rescued.is_whole)
    throw Error(ErrorCode::kInput, path +
                                       ": no job can be read, and nothing was changed; replace it with a backup, or "
                                       "move it away and start once with 'multum serve --new-ledger'");
  RescueReport report;
  report.tables = std::move(rescued.tables);
  report.kept = take_place(path, scaffold.fresh);
  return report;
}

}  // namespace multum
