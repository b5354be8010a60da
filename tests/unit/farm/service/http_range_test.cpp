// SPDX-License-Identifier: Apache-2.0
// Tests byte ranges as in RFC 9110, section 14.
#include "host/farm/service/http/http_range.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "host/farm/service/files/result_listing.h"
#include "host/farm/service/http/result_archive.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

std::string text_of(const std::optional<ByteRange>& range) {
  return range ? std::to_string(range->first) + "+" + std::to_string(range->count) : "none";
}

TEST(HttpRangeTest, OneRangeIsRead) {
  const auto read = [](const char* field, std::uint64_t bytes = 100) {
    return text_of(parse_byte_range(field, bytes));
  };
  EXPECT_EQ(read("bytes=0-0"), "0+1");
  EXPECT_EQ(read("bytes=10-19"), "10+10");
  EXPECT_EQ(read("Bytes= 10-"), "10+90");
  EXPECT_EQ(read("bytes=10-1000"), "10+90");
  EXPECT_EQ(read("bytes=-10"), "90+10");
  EXPECT_EQ(read("bytes=-1000"), "0+100");
  EXPECT_EQ(read("bytes=0-99999999999999999999999"), "0+100");
  for (const char* beyond : {"bytes=100-", "bytes=100-200", "bytes=99999999999999999999999-", "bytes=-0"})
    EXPECT_EQ(parse_byte_range(beyond, 100)->count, 0u) << beyond;
  EXPECT_EQ(parse_byte_range("bytes=0-", 0)->count, 0u);
  for (const char* none : {"", "bytes", "bytes=", "bytes=-", "bytes=5-4", "bytes=a-b", "bytes=1-2,4-5", "items=0-1",
                           "bytes=0x1-2", "bytes=--1", "bytes=1--2", "bytes=+1-2"})
    EXPECT_EQ(read(none), "none") << none;
}

std::string sent(const HttpResponse& response) {
  if (!response.made) return "the file";
  const HttpBodyPart part = response.part.value_or(HttpBodyPart{0, response.made->bytes()});
  if (part.first > 0) response.made->skip(part.first);
  std::string bytes(part.count, '?');
  EXPECT_EQ(response.made->read(bytes.data(), bytes.size()), bytes.size());
  return bytes;
}

std::string header_of(const HttpResponse& response, const std::string& name) {
  const auto found = std::find_if(response.headers.begin(), response.headers.end(),
                                  [&](const auto& one) { return one.first == name; });
  return found == response.headers.end() ? "" : found->second;
}

TEST(HttpRangeTest, AFileIsSentInParts) {
  const TemporaryFolder folder;
  testing::write_bytes(folder / "a", "0123456789");
  const auto answer = [&](const RangeRequest& request, bool is_head = false) {
    HttpResponse response;
    response.file = std::make_shared<OpenFile>(::open((folder / "a").c_str(), O_RDONLY | O_CLOEXEC));
    serve_range(response, request, is_head);
    return response;
  };
  const HttpResponse whole = answer({});
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(header_of(whole, "Accept-Ranges"), "bytes");
  const std::string etag = header_of(whole, "ETag");
  EXPECT_TRUE(etag.starts_with('"') && etag.ends_with('"')) << "a strong one";
  const HttpResponse part = answer({"bytes=3-5", ""});
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(header_of(part, "Content-Range"), "bytes 3-5/10");
  EXPECT_EQ(header_of(part, "ETag"), etag);
  EXPECT_EQ(sent(part), "345");
  EXPECT_EQ(sent(answer({"bytes=-1", etag})), "9");
  const HttpResponse beyond = answer({"bytes=10-", ""});
  EXPECT_EQ(beyond.status, 416);
  EXPECT_EQ(header_of(beyond, "Content-Range"), "bytes */10");
  // The service sends the whole file if the request names another version of the file, a time or a weak tag, or if it
  // asks for several parts or only for the header.
  for (const RangeRequest& other : std::vector<RangeRequest>{{"bytes=3-5", "\"other\""},
                                                             {"bytes=3-5", "Fri, 27 Nov 2026 10:00:00 GMT"},
                                                             {"bytes=3-5", "W/" + etag},
                                                             {"bytes=0-1,3-5", ""}})
    EXPECT_EQ(answer(other).status, 200) << other.range << other.if_range;
  EXPECT_EQ(answer({"bytes=3-5", ""}, true).status, 200);
  for (const std::string& known : {etag, "\"a\", W/" + etag, std::string("*")}) {
    const HttpResponse unchanged = answer({"bytes=3-5", "", known});
    EXPECT_EQ(unchanged.status, 304) << known;
    EXPECT_FALSE(unchanged.file || unchanged.made);
  }
  EXPECT_EQ(answer({"", "", "\"another\""}).status, 200);
  testing::write_bytes(folder / "a", "changed, and longer");
  EXPECT_NE(header_of(answer({}), "ETag"), etag);
  EXPECT_EQ(answer({"bytes=3-5", etag}).status, 200);
}

TEST(HttpRangeTest, AnArchiveIsTheSameFromAnywhere) {
  const TemporaryFolder folder;
  const ResultSeal seal = {"a key"};
  fs::create_directories(folder / "r/sub");
  testing::write_bytes(folder / "r/a", std::string(1000, 'a'));
  testing::write_bytes(folder / "r/sub/caf\xe9", std::string(700, 'b'));
  testing::write_bytes(folder / "r/empty", "");
  write_result_listing(folder / "r", seal);
  const auto archive = [&] {
    return std::make_shared<ResultArchive>(OpenFile(::open((folder / "r").c_str(), O_RDONLY | O_DIRECTORY)), "r", seal);
  };
  HttpResponse all;
  all.made = archive();
  const std::string whole = sent(all);
  EXPECT_EQ(whole.size(), all.made->bytes());
  EXPECT_NE(whole.find("hdrcharset=BINARY"), std::string::npos) << "the header must say that the name is not UTF-8";
  for (const std::size_t first : {1u, 100u, 512u, 700u, 1500u, 2048u, 3000u}) {
    HttpResponse rest;
    rest.made = archive();
    serve_range(rest, {"bytes=" + std::to_string(first) + "-", ""}, false);
    EXPECT_EQ(rest.status, 206);
    EXPECT_EQ(sent(rest), whole.substr(first)) << first;
  }
  EXPECT_EQ(archive()->etag(), all.made->etag());
  testing::write_bytes(folder / "r/a", std::string(1000, 'c'));
  write_result_listing(folder / "r", seal);
  EXPECT_NE(archive()->etag(), all.made->etag());
}

}  // namespace
}  // namespace multum
