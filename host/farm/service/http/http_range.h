// SPDX-License-Identifier: Apache-2.0
// Byte ranges (RFC 9110, section 14): a download that broke off goes on where it was. One range is served; of several,
// and of what is none, all of the body is, as the RFC allows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/farm/service/http/http_server.h"

namespace multum {

using ByteRange = HttpBodyPart;  // count 0: none of it is there

/// What "bytes=0-99", "bytes=100-" or "bytes=-100" asks of a body of `bytes`; nullopt: nothing that is served.
std::optional<ByteRange> parse_byte_range(std::string_view field, std::uint64_t bytes);

/// What a request says of the state of a body that it knows, and of ranges; empty: nothing.
struct RangeRequest {
  std::string range, if_range, if_none_match = {};
};
RangeRequest range_request(const HttpRequest& request);

/// Makes an answer of status 200 with a file, or with a body that can be read from anywhere, the one to this request:
/// 304 for who has it already, 206 with a part, 416 where there is no such part. It says by ETag which state of the
/// file it is, and that ranges are served. `is_head`: ranges are for GET alone.
void serve_range(HttpResponse& response, const RangeRequest& request, bool is_head);

}  // namespace multum
