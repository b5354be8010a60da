// SPDX-License-Identifier: Apache-2.0
// Where a job makes its result before it has its name: a hidden folder of its own beside the output, on the same file
// system, so that a rename publishes it and nothing half made is ever seen.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace multum {

/// DIR/.multum-INSTANCE-ID of DIR/NAME. `instance` tells daemons apart that write into one folder.
std::string staging_folder(const std::string& output, const std::string& instance, std::int64_t id);
/// Where in it the result is made: under its own name.
std::string staged_path(const std::string& output, const std::string& instance, std::int64_t id);

/// "INODE:BYTES:NANOSECONDS" of a file, or of a folder's inode alone; empty when it is not there. A rename keeps it.
std::string file_identity(const std::string& path);

/// Gives the staged result its final name, syncs the folder, and removes the staging folder. A file takes the place of
/// a file, a folder that of a folder, whole at any moment. When the result has its name already - a daemon died between
/// the rename and its note - only the rest is done. Throws Error(kEnvironment) when neither is `identity`.
void publish(const std::string& output, const std::string& instance, std::int64_t id, const std::string& identity);

/// Removes the folder and all in it, if it is there.
void remove_staging(const std::string& output, const std::string& instance, std::int64_t id);

/// Staging folders of `instance` in these folders whose jobs the ledger is finished with: removes them, returns their
/// paths.
std::vector<std::string> sweep_staging(const std::vector<std::string>& folders, const std::string& instance,
                                       const std::function<bool(std::int64_t)>& is_finished_with);

}  // namespace multum
