// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/output_paths.h"

#include <fmt/format.h>

#include <unistd.h>

#include <filesystem>
#include <mutex>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

bool same_file(const std::string& a, const std::string& b) {
  std::error_code ignored;  // a file that does not exist yet can be in a folder that has several names
  return fs::equivalent(a, b, ignored) || canonical_name(a) == canonical_name(b);
}

// Names are written to file lists, logs and terminals, where a control character could have an effect.
void check_name(const fs::path& name, const std::string& path) {
  if (holds_control(name.string()))
    throw Error(ErrorCode::kUsage, fmt::format("{}: its name contains a control character, expected a name without one",
                                               shown_text(path)));
}

// The folders that were created. Each folder comes after the folders that contain it.
struct NewFolderList {
  std::mutex mutex;
  int keepers = 0;
  std::vector<fs::path> paths;
};

NewFolderList& new_folders() {
  static NewFolderList list;
  return list;
}

}  // namespace

NewFolders::NewFolders() {
  NewFolderList& list = new_folders();
  const std::lock_guard lock(list.mutex);
  ++list.keepers;
}

NewFolders::~NewFolders() {
  NewFolderList& list = new_folders();
  const std::lock_guard lock(list.mutex);
  if (--list.keepers > 0) return;
  // rmdir() fails if a folder is not empty, so such a folder remains.
  for (auto path = list.paths.rbegin(); path != list.paths.rend(); ++path) ::rmdir(path->c_str());
  list.paths.clear();
}

std::string path_beside(const std::string& file, const std::string& path) {
  return path.empty() ? "" : (fs::path(file).parent_path() / path).lexically_normal().string();
}

std::string canonical_name(const std::string& path) {
  std::error_code ignored;
  return fs::weakly_canonical(fs::absolute(path, ignored), ignored).string();
}

void check_paths_differ(const std::vector<std::string>& inputs, const std::vector<std::string>& outputs) {
  std::vector<std::string> others = inputs;
  for (const std::string& output : outputs) {
    if (output.empty()) continue;
    check_name(fs::path(output).filename(), output);
    for (const std::string& other : others)
      if (!other.empty() && same_file(output, other))
        throw Error(ErrorCode::kUsage,
                    output + ": is named twice, expected different files for all inputs and outputs");
    others.push_back(output);
  }
}

void make_folder(const std::string& path) {
  std::error_code error;
  std::vector<fs::path> made;  // the innermost folder comes first
  for (fs::path missing = fs::absolute(path, error); !missing.empty() && !fs::exists(missing, error);
       missing = missing.parent_path()) {
    check_name(missing.filename(), path);
    made.push_back(missing);
  }
  error.clear();
  std::filesystem::create_directories(path, error);
  NewFolderList& list = new_folders();
  const std::lock_guard lock(list.mutex);
  if (list.keepers > 0) list.paths.insert(list.paths.end(), made.rbegin(), made.rend());
  if (error) throw Error(ErrorCode::kEnvironment, path + ": cannot create the folder: " + error.message());
}

void make_folder_of(const std::string& file) {
  if (const fs::path folder = fs::path(file).parent_path(); !folder.empty()) make_folder(folder.string());
}

std::string existing_part(const std::string& path) {
  std::error_code error;
  std::filesystem::path folder = path;
  while (!folder.empty() && !std::filesystem::is_directory(folder, error)) folder = folder.parent_path();
  return folder.empty() ? "." : folder.string();
}

void check_writable(const std::string& path) {
  check_name(fs::path(path).filename(), path);
  // Permissions do not tell whether the file can be written, for example on a read-only disk or for root. Therefore a
  // file is created. It is removed together with the probe.
  const AtomicFile probe(path);
}

}  // namespace multum
