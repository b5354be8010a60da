// SPDX-License-Identifier: Apache-2.0
// The key with which a service recognizes the folders that it has published (result_listing.h).
#pragma once

#include <string>

namespace multum {

/// The key of the service. The key is empty for workers, which only read. Any listing is then accepted.
struct ResultSeal {
  std::string key;
};

/// Reads the key from a file in the daemon's data folder, which jobs cannot read. Creates the file at the first start.
/// Throws Error(kEnvironment).
ResultSeal take_up_seal(const std::string& path);

}  // namespace multum
