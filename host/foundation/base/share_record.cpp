// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/share_record.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

// A record needs a few hundred bytes per sample of each texture. A much larger file cannot be a record and is not read.
constexpr std::int64_t kBytesMax = std::int64_t{256} << 20;

[[noreturn]] void refuse(const ShareName& share, const std::string& found) {
  throw Error(ErrorCode::kEnvironment, share.path() + ": " + found + share.remedy());
}

std::string text_of(const ShareName& share) {
  std::error_code ignored;
  if (!std::filesystem::exists(share.path(), ignored)) refuse(share, "is missing");
  try {
    ByteFile file(share.path());
    if (file.size() > kBytesMax)
      refuse(share, fmt::format("has {} bytes, expected at most {}", file.size(), kBytesMax));
    return file.size() > 0 ? file.bytes(0, file.size(), "a share's record") : "";
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kEnvironment) throw;
    throw Error(ErrorCode::kEnvironment, error.what() + share.remedy());
  }
}

nlohmann::json checked(const ShareName& share, const std::string& text) {
  const std::size_t end = text.find('\n');
  if (end == std::string::npos || !text.ends_with('\n')) refuse(share, "is incomplete, or not a record of a share");
  const std::string line = text.substr(0, end);
  if (text.substr(end + 1) != hash_text(line) + "\n") refuse(share, "is damaged: its hash does not match its contents");
  nlohmann::json json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object()) refuse(share, "is not a record of a share");
  return json;
}

}  // namespace

std::string ShareName::path() const { return fmt::format("{}/shards/{}-of-{}.shard", folder, index, count); }

std::string ShareName::remedy() const { return fmt::format(": --shard {}/{} makes it again", index, count); }

void write_share_record(const ShareName& share, const std::string& key, const nlohmann::json& content) {
  const nlohmann::json json = {{"multumShare", 1},  {"kind", share.kind}, {"share", share.index},
                               {"of", share.count}, {"key", key},         {"content", content}};
  const std::string line = json_text(json);
  make_folder(std::filesystem::path(share.path()).parent_path().string());
  write_text_file(share.path(), line + "\n" + hash_text(line) + "\n");
}

nlohmann::json read_share_record(const ShareName& share, const std::string& key) {
  const nlohmann::json json = checked(share, text_of(share));
  const nlohmann::json expected = {
      {"multumShare", 1}, {"kind", share.kind}, {"share", share.index}, {"of", share.count}};
  for (const auto& [name, value] : expected.items())
    if (json.value(name, nlohmann::json()) != value)
      refuse(share,
             fmt::format("says {} {}, expected {}", name, json.value(name, nlohmann::json()).dump(), value.dump()));
  if (json.value("key", nlohmann::json()) != key)
    refuse(share, "was made with different inputs, different settings or a different version");
  if (!json.contains("content") || !json["content"].is_object()) refuse(share, "has no content");
  return json["content"];
}

}  // namespace multum
