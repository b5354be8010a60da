// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/slurm_notes.h"

#include <array>
#include <string>

namespace multum {
namespace {

const std::string kSelectParts =
    "SELECT batch, item, job, attempt, share, round, slurm_job, state, node, exit_code, message FROM slurm_parts ";

constexpr std::array kPartStateNames = {"sent", "succeeded", "failed", "lost", "cancelled"};

}  // namespace

const char* slurm_part_state_name(SlurmPartState state) { return kPartStateNames.at(static_cast<std::size_t>(state)); }

void SlurmNotes::add(const SlurmPart& part) {
  database_.statement("INSERT INTO slurm_parts (batch, item, job, attempt, share, round) VALUES (?, ?, ?, ?, ?, ?)")
      .bind(1, part.batch)
      .bind(2, part.item)
      .bind(3, part.job)
      .bind(4, part.attempt)
      .bind(5, part.share)
      .bind(6, part.round)
      .run();
}

void SlurmNotes::set_slurm_job(std::int64_t batch, std::int64_t slurm_job) {
  database_.statement("UPDATE slurm_parts SET slurm_job = ? WHERE batch = ?").bind(1, slurm_job).bind(2, batch).run();
}

void SlurmNotes::update(const SlurmPart& part) {
  database_
      .statement("UPDATE slurm_parts SET state = ?, node = ?, exit_code = ?, message = ? WHERE batch = ? AND item = ?")
      .bind(1, static_cast<int>(part.state))
      .bind(2, part.node)
      .bind(3, part.exit_code)
      .bind(4, part.message)
      .bind(5, part.batch)
      .bind(6, part.item)
      .run();
}

std::vector<SlurmPart> SlurmNotes::rows(SqliteStatement& query) {  // reads the rows of kSelectParts
  std::vector<SlurmPart> parts;
  while (query.step())
    parts.push_back({query.integer(0), static_cast<int>(query.integer(1)), query.integer(2),
                     static_cast<int>(query.integer(3)), query.text(4), static_cast<int>(query.integer(5)),
                     query.optional_integer(6), static_cast<SlurmPartState>(query.integer(7)), query.text(8),
                     query.optional_int(9), query.text(10)});
  return parts;
}

std::vector<SlurmPart> SlurmNotes::sent() {
  static const std::string sql = kSelectParts + "WHERE state = 0 ORDER BY batch, item";
  return rows(database_.statement(sql.c_str()));
}

bool SlurmNotes::has_sent(std::int64_t job, int attempt) {
  SqliteStatement& query =
      database_.statement("SELECT 1 FROM slurm_parts WHERE job = ? AND attempt = ? AND state = 0 LIMIT 1");
  query.bind(1, job).bind(2, attempt);
  const bool found = query.step();
  query.reset();
  return found;
}

std::vector<SlurmPart> SlurmNotes::of_job(std::int64_t job) {
  static const std::string sql = kSelectParts + "WHERE job = ? ORDER BY batch, item";
  SqliteStatement& query = database_.statement(sql.c_str());
  query.bind(1, job);
  return rows(query);
}

std::int64_t SlurmNotes::last_batch() {
  SqliteStatement& query = database_.statement("SELECT IFNULL(MAX(batch), 0) FROM slurm_parts");
  query.step();
  const std::int64_t last = query.integer(0);
  query.reset();
  return last;
}

void SlurmNotes::cancel_orphans() {
  database_
      .statement(
          "UPDATE slurm_parts SET state = 4, message = 'its attempt has ended' WHERE state = 0 AND NOT EXISTS (SELECT "
          "1 FROM jobs WHERE jobs.id = slurm_parts.job AND jobs.state = 2 AND jobs.attempt = slurm_parts.attempt)")
      .run();
}

}  // namespace multum
