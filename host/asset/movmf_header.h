// SPDX-License-Identifier: Apache-2.0
// The headers of a baked file's parts: attributes from what the file says of itself, and back. For host/asset alone.
#pragma once

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>

#include <string>
#include <vector>

#include "host/asset/movmf_mipmap.h"
#include "host/asset/movmf_parts.h"

namespace multum {

// What headers say that is known when the pixels are written: filled in at the end.
constexpr char kMeasuredErrorAttribute[] = "multum:measuredError";  // in the first part alone: it is long
constexpr char kContentHashAttribute[] = "multum:contentHash";      // in every part
constexpr int kContentHashDigits = 64;

/// One header a part, with spaces where the measured error and the content hash will be.
std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const MovmfWriteOptions& options);

/// All but pixels, from the first part's header; then checks that every part is there and as movmf_parts() says.
/// Throws Error(kInput) naming `path`, what was found and what was expected.
MovmfMipmap parse_headers(const Imf::MultiPartInputFile& file, const std::string& path);

}  // namespace multum
