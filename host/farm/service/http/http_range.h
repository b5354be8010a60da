// SPDX-License-Identifier: Apache-2.0
// Serves byte ranges (RFC 9110, section 14), so that a broken download can continue. Only a single range is served. For
// several ranges, or an invalid one, the whole body is sent, as the RFC allows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/farm/service/http/http_server.h"

namespace multum {

using ByteRange = HttpBodyPart;  // a count of 0 means that the range is outside the body

/// Parses "bytes=0-99", "bytes=100-" or "bytes=-100" for a body of `bytes`. Returns nullopt if such a range is not
/// served.
std::optional<ByteRange> parse_byte_range(std::string_view field, std::uint64_t bytes);

/// The header fields with which a request asks for ranges, or names the state of the body that the client already has.
/// If a header field is missing, its text is empty.
struct RangeRequest {
  std::string range, if_range, if_none_match = {};
};
RangeRequest range_request(const HttpRequest& request);

/// Adapts an answer of status 200, with a file or a seekable body, to this request. The status becomes 304 if the
/// client already has the body, 206 for a part of the body, and 416 for a part beyond its end. Adds the ETag of the
/// file's state, and announces ranges. If `is_head`, ignores ranges, which are only for GET.
void serve_range(HttpResponse& response, const RangeRequest& request, bool is_head);

}  // namespace multum
