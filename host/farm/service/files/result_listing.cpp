// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/files/result_listing.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/files/own_folder.h"
#include "host/foundation/sandbox/path_roots.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr off_t kListingMax = 16 << 20;  // bytes, enough for some hundred thousand files
constexpr int kDepthMax = 32;            // nested folders, each of which is an open file
constexpr char kSealWord[] = "seal ";
constexpr std::size_t kKeyDigits = 64;

using Listing = PublishedFiles;  // names with line breaks are not listed

std::string state_of(const struct stat& found) {
  return fmt::format("{} {}", found.st_size, found.st_mtim.tv_sec * 1000000000LL + found.st_mtim.tv_nsec);
}

OpenFile open_folder(int above, const std::string& name) {
  return OpenFile(::openat(above, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
}

[[noreturn]] void cannot_list(const std::string& path) { fail_by_errno(path, "cannot be listed"); }

std::string seal_line(const OpenFile& folder, const std::string& lines, const ResultSeal& seal) {
  struct stat found {};
  if (::fstat(folder.descriptor(), &found) != 0) return "";
  const std::string text = fmt::format("multum-result {}\n{}", found.st_ino, lines);
  unsigned char code[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  ::HMAC(EVP_sha256(), seal.key.data(), static_cast<int>(seal.key.size()),
         reinterpret_cast<const unsigned char*>(text.data()), text.size(), code, &size);
  std::string line = kSealWord;
  for (unsigned i = 0; i < size; ++i) line += fmt::format("{:02x}", code[i]);
  return line + "\n";
}

bool is_same(const std::string& a, const std::string& b) {
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

// Returns the lines of the listed files, or nothing if the seal is not from the service.
std::string sealed_lines(const OpenFile& folder, const std::string& text, const ResultSeal& seal) {
  if (seal.key.empty()) return text;
  const std::size_t before = text.rfind(std::string("\n") + kSealWord);
  const std::size_t begin = text.starts_with(kSealWord) ? 0 : before == std::string::npos ? text.size() : before + 1;
  const std::string lines = text.substr(0, begin);
  return is_same(text.substr(begin), seal_line(folder, lines, seal)) ? lines : "";
}

// An entry of an open folder that is not itself a folder. `path` is relative to the start of the walk.
struct Found {
  int folder;
  const std::string& name;
  const std::string& path;
  std::string state;
};

struct Walk {
  std::function<bool(const Found&)> at_file;  // ends the walk by returning false
  std::function<void(int above, const std::string& name)> after_folder = nullptr;

  bool run(const OpenFile& folder, const std::string& prefix = "", int depth = 0) const {
    if (depth > kDepthMax)
      throw Error(ErrorCode::kEnvironment,
                  fmt::format("{}: folders are nested more than {} levels deep", prefix, kDepthMax));
    for (const std::string& name : names_in(folder, prefix)) {
      struct stat found {};
      if (::fstatat(folder.descriptor(), name.c_str(), &found, AT_SYMLINK_NOFOLLOW) != 0)
        continue;  // removed meanwhile
      const std::string path = prefix + name;
      if (S_ISDIR(found.st_mode)) {
        const OpenFile below = open_folder(folder.descriptor(), name);
        if (!below.is_open() && errno != ENOENT && errno != ENOTDIR && errno != ELOOP) cannot_list(path);
        if (below.is_open() && !run(below, path + "/", depth + 1)) return false;
        if (after_folder) after_folder(folder.descriptor(), name);
      } else if (path != kResultListingName) {
        if (!at_file({folder.descriptor(), name, path, state_of(found)})) return false;
      }
    }
    return true;
  }
};

OpenFile opened(const std::string& folder) {
  OpenFile file = open_folder(AT_FDCWD, folder);
  if (!file.is_open()) cannot_list(folder);
  return file;
}

Listing read_listing(const OpenFile& folder, const std::string& path, const ResultSeal& seal) {
  // A pipe, a symbolic link or an endless file is not accepted as a listing.
  const OpenFile file(
      ::openat(folder.descriptor(), kResultListingName, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  // A listing that cannot be read at present does not count as missing.
  const auto cannot_read = [&] { fail_by_errno(path + "/" + kResultListingName, "cannot be read"); };
  if (!file.is_open() && errno != ENOENT && errno != ENOTDIR && errno != ELOOP) cannot_read();
  Listing listing;
  struct stat found {};
  if (!file.is_open() || ::fstat(file.descriptor(), &found) != 0 || !S_ISREG(found.st_mode) ||
      found.st_size > kListingMax)
    return listing;
  std::string text(static_cast<std::size_t>(found.st_size), '\0');
  const ssize_t count = ::pread(file.descriptor(), text.data(), text.size(), 0);
  if (count < 0) cannot_read();
  text.resize(static_cast<std::size_t>(count));
  std::istringstream in(sealed_lines(folder, text, seal));
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (second != std::string::npos) listing[line.substr(second + 1)] = line.substr(0, second);
  }
  return listing;
}

bool is_listed(const Listing& listing, const Found& found) {
  const auto line = listing.find(found.path);
  return line != listing.end() && line->second == found.state;
}

// Returns the first file that differs from the listing. `count` counts the unchanged files before it.
std::string first_unlisted(const OpenFile& folder, const Listing& listing, std::size_t& count) {
  std::string unlisted;
  Walk{[&](const Found& found) {
    const bool is_known = is_listed(listing, found);
    if (is_known) ++count;
    else unlisted = found.path;
    return is_known;
  }}.run(folder);
  return unlisted;
}

}  // namespace

ResultSeal take_up_seal(const std::string& path) {
  std::string key;
  if (std::ifstream file(path); std::getline(file, key) && key.size() == kKeyDigits) return {key};
  unsigned char random[kKeyDigits / 2];
  if (RAND_bytes(random, sizeof(random)) != 1)
    throw Error(ErrorCode::kEnvironment, path + ": cannot create a key: the system provides no random numbers");
  key.clear();
  for (const unsigned char byte : random) key += fmt::format("{:02x}", byte);
  ::unlink(path.c_str());  // remains of an interrupted start
  const OpenFile file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  const std::string line = key + "\n";
  if (!file.is_open() || ::write(file.descriptor(), line.data(), line.size()) != static_cast<ssize_t>(line.size()) ||
      ::fsync(file.descriptor()) != 0)
    fail_by_errno(path, "cannot be written");
  return {key};
}

void write_result_listing(const std::string& folder, const ResultSeal& seal) {
  const OpenFile file = opened(folder);
  std::string text;
  Walk{[&](const Found& found) {
    // Removes a temporary file whose writer could neither finish it nor find it again, because folders were swapped.
    if (is_temporary_name(found.name) && ::unlinkat(found.folder, found.name.c_str(), 0) == 0) return true;
    if (found.path.find('\n') == std::string::npos) text += fmt::format("{} {}\n", found.state, found.path);
    return true;
  }}.run(file);
  if (!seal.key.empty()) text += seal_line(file, text, seal);
  // Writes through /proc, so that renaming the folder has no effect.
  write_text_file(fmt::format("/proc/self/fd/{}/{}", file.descriptor(), kResultListingName), text);
}

std::string unlisted_in(const std::string& folder, const ResultSeal& seal) {
  const OpenFile file = opened(folder);
  std::size_t count = 0;
  return first_unlisted(file, read_listing(file, folder, seal), count);
}

bool is_as_published(const std::string& folder, const ResultSeal& seal) {
  const OpenFile file = opened(folder);
  const Listing listing = read_listing(file, folder, seal);
  std::size_t count = 0;
  return !listing.empty() && first_unlisted(file, listing, count).empty() && count == listing.size();
}

bool remove_listed(const std::string& folder, const ResultSeal& seal) {
  bool is_all = true;
  {
    const OpenFile file = opened(folder);
    const Listing listing = read_listing(file, folder, seal);
    const auto remove_file = [&](const Found& found) {
      const bool is_removed = is_listed(listing, found) && ::unlinkat(found.folder, found.name.c_str(), 0) == 0;
      is_all = is_all && is_removed;
      return true;
    };
    const auto remove_if_empty = [](int above, const std::string& name) {
      ::unlinkat(above, name.c_str(), AT_REMOVEDIR);
    };
    Walk{remove_file, remove_if_empty}.run(file);
    if (is_all) ::unlinkat(file.descriptor(), kResultListingName, 0);
  }
  ::rmdir(folder.c_str());
  return is_all;
}

std::size_t listing_bytes(const OpenFile& folder) {
  struct stat found {};
  const bool is_there = ::fstatat(folder.descriptor(), kResultListingName, &found, AT_SYMLINK_NOFOLLOW) == 0;
  return is_there && found.st_size <= kListingMax ? static_cast<std::size_t>(found.st_size) : 0;
}

PublishedFiles published_files(const OpenFile& folder, const std::string& path, const ResultSeal& seal) {
  return read_listing(folder, path, seal);
}

OpenFile open_published(const OpenFile& folder, const std::string& name, const std::string& state) {
  // Any user who has write permission in the folder may have written the listing.
  const bool is_plain = fs::path(name).lexically_normal() == name && !name.starts_with("..") && !name.starts_with('/');
  OpenFile file = is_plain ? open_beneath_folder(folder, name, O_RDONLY | O_NONBLOCK) : OpenFile();
  if (!file.is_open() || !is_in_state(file, state))
    throw Error(ErrorCode::kUsage, fmt::format("{}: is missing, or has changed since it was published", name));
  return file;
}

bool is_in_state(const OpenFile& file, const std::string& state) {
  struct stat found {};
  return ::fstat(file.descriptor(), &found) == 0 && S_ISREG(found.st_mode) && state_of(found) == state;
}

}  // namespace multum
