// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/baked_verify.h"

#include "host/formats/asset/baked_file.h"
#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/formats/asset/representation.h"

namespace multum {

std::vector<VerifyFinding> verify_baked(const std::string& path, int threads) {
  return is_pyramid_file(path) ? verify_pyramid(path, threads) : representation_of(path).verify(path, threads);
}

}  // namespace multum
