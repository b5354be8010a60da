// SPDX-License-Identifier: Apache-2.0
#include "host/export/fit_journal.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/base/error.h"
#include "host/base/files/checksum.h"
#include "host/base/size_of.h"
#include "kernels/shared/one_lobe.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kChecksumBytes = 16;  // of Checksum::text()

using RecordHead = std::array<std::uint32_t, 4>;  // level, first row, width, height

std::uint64_t float_count(const RecordHead& head) { return std::uint64_t{MULTUM_ONE_LOBE_FITTED} * head[2] * head[3]; }

std::string checksum_of(const RecordHead& head, const std::vector<float>& fitted) {
  Checksum checksum;
  checksum.update(head.data(), sizeof head);
  checksum.update(fitted.data(), fitted.size() * sizeof(float));
  return checksum.text();
}

bool read_floats(std::ifstream& in, std::vector<float>& to) {
  in.read(reinterpret_cast<char*>(to.data()), static_cast<std::streamsize>(to.size() * sizeof(float)));
  return in.good();
}

}  // namespace

std::unique_ptr<FitJournal> FitJournal::open(const std::string& output, const std::string& key) {
  std::unique_ptr<PartialFolder> folder = PartialFolder::take(output);
  if (folder == nullptr) return nullptr;
  return std::unique_ptr<FitJournal>(new FitJournal(std::move(folder), key));
}

FitJournal::FitJournal(std::unique_ptr<PartialFolder> folder, const std::string& key) : folder_(std::move(folder)) {
  if (const std::uint64_t bytes = read_fits(key); bytes > 0) {
    std::error_code ignored;
    fs::resize_file(fits_path(), bytes, ignored);
    return;
  }
  folder_->clear();
  std::ofstream out(fits_path(), std::ios::binary);
  out << key << '\n';
  if (!out.flush()) throw Error(ErrorCode::kEnvironment, fits_path() + ": cannot be written: " + std::strerror(errno));
}

std::uint64_t FitJournal::read_fits(const std::string& key) {
  std::ifstream in(fits_path(), std::ios::binary);
  std::string line;
  if (!std::getline(in, line) || line != key) return 0;
  std::uint64_t good = line.size() + 1;
  std::error_code error;
  const std::uint64_t size = fs::file_size(fits_path(), error);
  while (!error) {
    RecordHead head{};
    in.read(reinterpret_cast<char*>(head.data()), sizeof head);
    const std::uint64_t left = size - good, ends = sizeof head + kChecksumBytes;
    if (!in || left < ends || float_count(head) > (left - ends) / sizeof(float)) break;
    std::vector<float> fitted(float_count(head));
    std::string checksum(kChecksumBytes, ' ');
    if (!read_floats(in, fitted)) break;
    in.read(checksum.data(), static_cast<std::streamsize>(checksum.size()));
    if (!in || checksum_of(head, fitted) != checksum) break;
    found_[{head[0], head[1]}] = {good + sizeof head, head[2], head[3]};
    good += ends + fitted.size() * sizeof(float);
  }
  return good;
}

bool FitJournal::find(int level, int first_row, int width, int height, std::vector<float>& fitted) {
  const auto found = found_.find({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(first_row)});
  if (found == found_.end() || size_of(width) != found->second.width || size_of(height) != found->second.height)
    return false;
  std::ifstream in(fits_path(), std::ios::binary);
  in.seekg(static_cast<std::streamoff>(found->second.offset));
  fitted.resize(MULTUM_ONE_LOBE_FITTED * size_of(width) * size_of(height));
  if (!read_floats(in, fitted)) return false;
  rows_resumed_ += size_of(height);
  return true;
}

void FitJournal::add(int level, int first_row, int width, int height, const std::vector<float>& fitted) {
  const RecordHead head = {static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(first_row),
                           static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  MULTUM_CHECK(fitted.size() == float_count(head));
  const std::string checksum = checksum_of(head, fitted);
  std::ofstream out(fits_path(), std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(head.data()), sizeof head);
  out.write(reinterpret_cast<const char*>(fitted.data()), static_cast<std::streamsize>(fitted.size() * sizeof(float)));
  out.write(checksum.data(), static_cast<std::streamsize>(checksum.size()));
  if (!out.flush()) throw Error(ErrorCode::kEnvironment, fits_path() + ": cannot be written: " + std::strerror(errno));
}

}  // namespace multum
