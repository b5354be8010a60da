// SPDX-License-Identifier: Apache-2.0
// Adds the attributes of lobes to the headers of movmf files, beside those of all baked files
// (host/formats/asset/baked_header.h), and reads them. For host/formats/asset alone.
#pragma once

#include <ImfHeader.h>

#include <string>
#include <vector>

#include "host/formats/asset/baked_header.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/lobes/movmf_parts.h"

namespace multum {

/// One header a part, with spaces where the measured error and the content hash will be.
std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const BakedWriteOptions& options);

/// Reads everything but pixels from the first part's header. Throws Error(kInput) naming `path`, what was found and
/// what was expected.
MovmfMipmap parse_header(const Imf::Header& header, const std::string& path);

}  // namespace multum
