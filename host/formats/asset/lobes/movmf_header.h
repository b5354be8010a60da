// SPDX-License-Identifier: Apache-2.0
// Writes and reads the attributes that only movmf files have. host/formats/asset/baked_header.h handles the attributes
// of all baked files. Only host/formats/asset uses this file.
#pragma once

#include <ImfHeader.h>

#include <string>
#include <vector>

#include "host/formats/asset/baked_header.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/lobes/movmf_parts.h"

namespace multum {

/// Makes one header per part. Spaces reserve room for the measured error and the content hash.
std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const BakedWriteOptions& options);

/// Reads everything except pixels from the header of the first part. Throws Error(kInput), which names `path`, what was
/// found and what was expected.
MovmfMipmap parse_header(const Imf::Header& header, const std::string& path);

}  // namespace multum
