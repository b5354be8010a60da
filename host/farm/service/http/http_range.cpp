// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/http/http_range.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>

#include "host/farm/service/http/http_reply.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

std::optional<std::uint64_t> number_of(std::string_view digits) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (digits.empty() || end != digits.data() + digits.size()) return std::nullopt;
  return error == std::errc::result_out_of_range ? UINT64_MAX : number;
}

// A body that is a part of a file.
class FilePart : public HttpBody {
 public:
  FilePart(std::shared_ptr<OpenFile> file, ByteRange part)
      : file_(std::move(file)), at_(part.first), left_(part.count) {}

  std::uint64_t bytes() const override { return left_; }
  std::size_t memory() const override { return sizeof(*this); }
  std::size_t read(char* to, std::size_t bytes_max) override {
    const std::size_t wanted = std::min<std::uint64_t>(bytes_max, left_);
    ssize_t count = -1;
    do count = ::pread(file_->descriptor(), to, wanted, static_cast<off_t>(at_));
    while (count < 0 && errno == EINTR);
    if (count < 0) fail_by_errno("a file that is being sent", "cannot be read further");
    at_ += static_cast<std::uint64_t>(count);
    left_ -= static_cast<std::uint64_t>(count);
    return static_cast<std::size_t>(count);
  }

 private:
  std::shared_ptr<OpenFile> file_;
  std::uint64_t at_, left_;
};

// A strong validator. If any byte of a file changes, at least one of these values changes too, unless the clock's
// resolution is too low.
std::string etag_of(const struct stat& found) {
  return fmt::format("\"{:x}-{:x}-{:x}\"", found.st_ino, found.st_size,
                     found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec);
}

// Returns whether the list contains the tag or its weak form.
bool knows(std::string_view list, std::string_view etag) {
  while (!list.empty()) {
    std::string_view one = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), one.size() + 1));
    while (one.starts_with(' ')) one.remove_prefix(1);
    while (one.ends_with(' ')) one.remove_suffix(1);
    if (one.starts_with("W/")) one.remove_prefix(2);
    if (one == etag || one == "*") return true;
  }
  return false;
}

}  // namespace

std::optional<ByteRange> parse_byte_range(std::string_view field, std::uint64_t bytes) {
  const std::size_t equals = field.find('=');
  std::string unit(field.substr(0, equals));
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (equals == std::string_view::npos || unit != "bytes") return std::nullopt;
  std::string_view range = field.substr(equals + 1);
  while (range.starts_with(' ') || range.starts_with('\t')) range.remove_prefix(1);
  while (range.ends_with(' ') || range.ends_with('\t')) range.remove_suffix(1);
  const std::size_t dash = range.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::optional<std::uint64_t> first = number_of(range.substr(0, dash)), last = number_of(range.substr(dash + 1));
  if (dash == 0) {  // a range of the last bytes
    if (!last) return std::nullopt;
    const std::uint64_t count = std::min(*last, bytes);
    return ByteRange{bytes - count, count};
  }
  const bool is_open = dash + 1 == range.size();
  if (!first || (!is_open && (!last || *last < *first))) return std::nullopt;
  if (*first >= bytes) return ByteRange{};
  const std::uint64_t end = is_open ? bytes : std::min(*last, bytes - 1) + 1;
  return ByteRange{*first, end - *first};
}

RangeRequest range_request(const HttpRequest& request) {
  const auto field = [&](const char* name) {
    const auto found = request.headers.find(name);
    return found == request.headers.end() ? std::string() : found->second;
  };
  return {field("range"), field("if-range"), field("if-none-match")};
}

void serve_range(HttpResponse& response, const RangeRequest& request, bool is_head) {
  if (response.status != 200 || (!response.file && !response.made)) return;
  std::uint64_t bytes = 0;
  std::string etag;
  struct stat found {};
  if (response.made) {
    bytes = response.made->bytes();
    etag = response.made->etag();
  } else if (::fstat(response.file->descriptor(), &found) == 0) {
    bytes = static_cast<std::uint64_t>(found.st_size);
    etag = etag_of(found);
  }
  if (etag.empty()) return;
  response.headers.emplace_back("Accept-Ranges", "bytes");
  response.headers.emplace_back("ETag", etag);
  if (knows(request.if_none_match, etag)) {
    response.status = 304;
    response.file = nullptr;
    response.made = nullptr;
    return;
  }
  // A time or a weak tag is not a strong validator here, so the whole body is sent.
  if (is_head || request.range.empty() || (!request.if_range.empty() && request.if_range != etag)) return;
  const std::optional<ByteRange> part = parse_byte_range(request.range, bytes);
  if (!part) return;
  if (part->count == 0) {
    response =
        refusal_response({416,
                          "range",
                          fmt::format("the file has {} bytes, and the requested range is outside the file", bytes),
                          {{"Content-Range", fmt::format("bytes */{}", bytes)}, {"Accept-Ranges", "bytes"}}});
    return;
  }
  if (response.made) {
    response.part = *part;
  } else {
    response.made = std::make_shared<FilePart>(std::move(response.file), *part);
    response.file = nullptr;
  }
  response.status = 206;
  response.headers.emplace_back("Content-Range",
                                fmt::format("bytes {}-{}/{}", part->first, part->first + part->count - 1, bytes));
}

}  // namespace multum
