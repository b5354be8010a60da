// SPDX-License-Identifier: Apache-2.0
// Stages a job's result in a hidden folder next to the output, on the same file system. A rename publishes the result,
// so an incomplete result is never visible. Names are relative to the descriptor of the output's folder, which
// PathRoots opens. Changes to symbolic links or folders above it therefore have no effect.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/farm/service/files/result_listing.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

/// Returns DIR/.multum-INSTANCE-ID for DIR/NAME. `instance` distinguishes daemons that write into one folder.
std::string staging_folder(const std::string& output, const std::string& instance, std::int64_t id);
/// Returns the path of the result in the staging folder, under its own name. A worker runs in that folder, so it uses
/// only the name.
std::string staged_path(const std::string& output, const std::string& instance, std::int64_t id);
std::string staged_name(const std::string& output);

/// Opens a staging folder, and creates it if it is missing (host/foundation/base/files/own_folder.h). Throws like
/// PathRoots::open_folder_of(). Throws Error(kEnvironment) if another user's file is in its place.
OpenFile open_staging_folder(const PathRoots& roots, const std::string& path);

/// Returns "INODE:BYTES:NANOSECONDS" of a file, or the inode of a folder, or "" if it is missing. A rename does not
/// change the identity. This function is for inputs, because it follows links.
std::string file_identity(const std::string& path);
/// Returns the identity of a result in the form of file_identity(). Follows no symbolic links, and returns "" for a
/// link or a path behind a link. Throws Error(kEnvironment) when the identity cannot be determined.
std::string result_identity(const PathRoots& roots, const std::string& path);

/// Returns whether the result is unchanged since it was published with this identity. A folder must have exactly its
/// published files. Follows no links. Throws Error(kEnvironment) when this cannot be determined.
bool is_as_made(const PathRoots& roots, const std::string& path, const std::string& identity, const ResultSeal& seal);

/// One job's result before it gets its final name.
class StagedResult {
 public:
  /// Throws like PathRoots::open_folder_of().
  StagedResult(const PathRoots& roots, const std::string& output, const std::string& instance, std::int64_t id,
               ResultSeal seal);

  /// Returns the identity of the staged result. The identity is empty if there is no result, or if the result is a
  /// symbolic link. Throws Error(kEnvironment) if another user's file is in the place of the staging folder.
  std::string identity() const;
  /// Throws Error(kUsage) when the result must not replace the existing entry. The entry is then a folder that contains
  /// more than an unchanged result of multum, a file in the place of a folder, or a folder in the place of a file.
  void check_place(bool is_folder) const;
  /// Gives the result its final name, syncs the folder, and removes the staging folder. A file replaces a file, and a
  /// folder replaces a result, in one step. If a daemon died after the rename but before the ledger recorded it, the
  /// result already has its final name. In that case, only the remaining steps are done. Returns the path of files that
  /// were added to the previous folder, or "" if there are none. Throws like check_place(). Throws Error(kEnvironment)
  /// when neither the staged nor the published result has `identity`.
  std::string publish(const std::string& identity) const;
  /// Removes the staging folder and its contents, if it exists.
  void remove() const;

 private:
  OpenFile open_staging() const;
  std::string staging_path() const;
  std::string put_aside(const OpenFile& staging) const;

  std::string output_, name_, staging_;
  std::int64_t id_;
  ResultSeal seal_;
  OpenFile folder_;
};

/// Removes from these folders the staging folders of `instance` whose jobs have ended in the ledger. Returns the paths
/// of the removed folders. Does not touch folders that are not below the roots.
std::vector<std::string> sweep_staging(const PathRoots& roots, const std::vector<std::string>& folders,
                                       const std::string& instance,
                                       const std::function<bool(std::int64_t)>& is_finished_with);

}  // namespace multum
