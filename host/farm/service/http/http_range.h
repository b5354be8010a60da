// SPDX-License-Identifier: Apache-2.0
// Serves byte ranges (RFC 9110, section 14), so that a broken download can continue. One range is served; for several
// ranges, or an invalid one, the whole body is sent, as the RFC allows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/farm/service/http/http_server.h"

namespace multum {

using ByteRange = HttpBodyPart;  // count 0: outside the body

/// Parses "bytes=0-99", "bytes=100-" or "bytes=-100" for a body of `bytes`; nullopt: not a range that is served.
std::optional<ByteRange> parse_byte_range(std::string_view field, std::uint64_t bytes);

/// Fields of a request about ranges and about a state of the body that the client knows; empty: not given.
struct RangeRequest {
  std::string range, if_range, if_none_match = {};
};
RangeRequest range_request(const HttpRequest& request);

/// Adapts an answer of status 200, with a file or a seekable body, to this request. The status becomes 304 if the
/// client has the body already, 206 for a part, 416 for a missing part. Adds the ETag of the file's state, and
/// announces ranges. `is_head`: ranges are only for GET.
void serve_range(HttpResponse& response, const RangeRequest& request, bool is_head);

}  // namespace multum
