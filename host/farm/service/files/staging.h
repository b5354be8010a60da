// SPDX-License-Identifier: Apache-2.0
// Stages a job's result before it has its name: a hidden folder of its own beside the output, on the same file system,
// so that a rename publishes it and nothing half made is ever seen. Names are used beneath the descriptor of the
// output's folder, as PathRoots opened it: whatever becomes of a link or a folder above, it is that folder's.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/farm/service/files/result_listing.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {

/// DIR/.multum-INSTANCE-ID of DIR/NAME. `instance` tells daemons apart that write into one folder.
std::string staging_folder(const std::string& output, const std::string& instance, std::int64_t id);
/// Path of the result within the folder, under its own name; and as a worker says it, which works within the folder.
std::string staged_path(const std::string& output, const std::string& instance, std::int64_t id);
std::string staged_name(const std::string& output);

/// Opens a staging folder, and makes it if it is missing (host/foundation/base/files/own_folder.h). Throws as
/// PathRoots::open_folder_of() does, and Error(kEnvironment) for what somebody else put in its place.
OpenFile open_staging_folder(const PathRoots& roots, const std::string& path);

/// "INODE:BYTES:NANOSECONDS" of a file, or of a folder's inode alone; empty when it is not there. A rename keeps it. An
/// input's: a link is followed.
std::string file_identity(const std::string& path);
/// The same of a result, by no link anywhere; empty also when it is a link, or lies behind one. Throws
/// Error(kEnvironment) when it cannot be known.
std::string result_identity(const PathRoots& roots, const std::string& path);

/// Does a result lie there as it was published, by its identity then? a folder with all that it held, and no more; by
/// no link. Throws Error(kEnvironment) when that cannot be known.
bool is_as_made(const PathRoots& roots, const std::string& path, const std::string& identity, const ResultSeal& seal);

/// One job's result on its way to its name.
class StagedResult {
 public:
  /// Throws as PathRoots::open_folder_of() does.
  StagedResult(const PathRoots& roots, const std::string& output, const std::string& instance, std::int64_t id,
               ResultSeal seal);

  /// Identity of the staged result; empty: there is none, or a link. Throws Error(kEnvironment) where somebody else has
  /// put something in the staging folder's place.
  std::string identity() const;
  /// Throws Error(kUsage) when something lies where the result is to be that it must not take the place of: a folder
  /// that holds anything but a result of multum, as it was published; a file where a folder is to be, or a folder where
  /// a file is.
  void check_place(bool is_folder) const;
  /// Gives it its final name, syncs the folder, and removes the staging folder. A file takes the place of a file, a
  /// folder that of a result, whole at any moment. When the result has its name already - a daemon died between the
  /// rename and its note - only the rest is done. Returns where something of the folder before was put that was not
  /// published; "": nowhere. Throws as check_place() does, and Error(kEnvironment) when neither is `identity`.
  std::string publish(const std::string& identity) const;
  /// Removes the staging folder and all in it, if it is there.
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

/// Staging folders of `instance` in these folders whose jobs the ledger is finished with: removes them, returns their
/// paths. Folders that are not below the roots any more are left alone.
std::vector<std::string> sweep_staging(const PathRoots& roots, const std::vector<std::string>& folders,
                                       const std::string& instance,
                                       const std::function<bool(std::int64_t)>& is_finished_with);

}  // namespace multum
