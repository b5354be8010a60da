// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/file_notes.h"

#include "host/foundation/base/path_text.h"

namespace multum {

std::vector<std::string> FileNotes::output_folders() {
  SqliteStatement& query =
      database_.statement("SELECT DISTINCT rtrim(output, replace(output, '/', '')) FROM jobs WHERE output <> ''");
  std::vector<std::string> folders;
  while (query.step()) folders.push_back(path_of_text(query.text(0)));
  return folders;
}

std::vector<FileNotes::LeftOver> FileNotes::left_overs(std::int64_t after, int limit) {
  SqliteStatement& query =
      database_.statement("SELECT job, output, identity FROM left_overs WHERE job > ? ORDER BY job LIMIT ?");
  query.bind(1, after).bind(2, limit);
  std::vector<LeftOver> found;
  while (query.step()) found.push_back({query.integer(0), path_of_text(query.text(1)), query.text(2)});
  return found;
}

void FileNotes::forget_left_over(std::int64_t job) {
  database_.statement("DELETE FROM left_overs WHERE job = ?").bind(1, job).run();
}

void FileNotes::note_upload(const std::string& path) {
  database_.check_may_change();
  database_.statement("INSERT OR IGNORE INTO uploads (path) VALUES (?)").bind(1, text_of_path(path)).run();
}

std::vector<std::string> FileNotes::uploads(const std::string& after, int limit) {
  SqliteStatement& query = database_.statement("SELECT path FROM uploads WHERE path > ? ORDER BY path LIMIT ?");
  query.bind(1, text_of_path(after)).bind(2, limit);
  std::vector<std::string> paths;
  while (query.step()) paths.push_back(path_of_text(query.text(0)));
  return paths;
}

void FileNotes::forget_upload(const std::string& path) {
  database_.statement("DELETE FROM uploads WHERE path = ?").bind(1, text_of_path(path)).run();
}

bool FileNotes::Uses::have(const std::string& path) const {
  for (const std::set<std::string>* names : {&outputs, &inputs}) {
    const auto below = names->lower_bound(path + "/");
    if (below != names->end() && below->starts_with(path + "/")) return true;
    for (std::size_t end = path.size(); end != 0 && end != std::string::npos; end = path.rfind('/', end - 1))
      if (names->contains(path.substr(0, end))) return true;
  }
  return false;
}

FileNotes::Uses FileNotes::uses() {
  Uses uses;
  SqliteStatement& outputs = database_.statement("SELECT DISTINCT output FROM jobs WHERE output <> ''");
  while (outputs.step()) uses.outputs.insert(path_of_text(outputs.text(0)));
  SqliteStatement& values = database_.statement(
      "SELECT json_each.value FROM jobs, json_each(jobs.parameters) WHERE jobs.state < 4 AND json_each.type = 'text' "
      "AND substr(json_each.value, 1, 1) = '/'");
  while (values.step()) uses.inputs.insert(path_of_text(values.text(0)));
  return uses;
}

}  // namespace multum
