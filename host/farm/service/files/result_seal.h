// SPDX-License-Identifier: Apache-2.0
// The key by which a service knows the folders that it has published (result_listing.h).
#pragma once

#include <string>

namespace multum {

/// Key of the service; empty: of who has none and only looks, as workers do: any listing is taken for the service's.
struct ResultSeal {
  std::string key;
};

/// Reads the file of the key, in the daemon's data where no job may read; makes it at the first start. Throws
/// Error(kEnvironment).
ResultSeal take_up_seal(const std::string& path);

}  // namespace multum
