// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/fit_journal.h"

#include <array>
#include <cstring>
#include <span>

#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"
#include "kernels/shared/one_lobe.h"

namespace multum {
namespace {

// A record consists of this head, followed by all planes.
using RecordHead = std::array<std::uint32_t, 4>;  // level, first row, width, height

std::uint64_t float_count(const RecordHead& head) { return std::uint64_t{MULTUM_ONE_LOBE_FITTED} * head[2] * head[3]; }

template <typename Values>
std::span<const std::uint8_t> bytes_of(const Values& values) {
  return {reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(values[0])};
}

}  // namespace

std::unique_ptr<FitJournal> FitJournal::open(const std::string& output, const std::string& key) {
  std::unique_ptr<FitJournal> journal(new FitJournal);
  journal->journal_ =
      RecordJournal::open(output, "fits", key, true, [&](RecordFile::Bytes bytes, const RecordFile::Place& place) {
        RecordHead head{};
        if (bytes.size() < sizeof head) return false;
        std::memcpy(head.data(), bytes.data(), sizeof head);
        if (bytes.size() != sizeof head + float_count(head) * sizeof(float)) return false;
        journal->found_[{head[0], head[1]}] = {place.offset + sizeof head, head[2], head[3]};
        return true;
      });
  return journal->journal_ != nullptr ? std::move(journal) : nullptr;
}

bool FitJournal::find(int level, int first_row, int width, int height, std::vector<float>& fitted) {
  const auto found = found_.find({static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(first_row)});
  if (found == found_.end() || size_of(width) != found->second.width || size_of(height) != found->second.height)
    return false;
  fitted.resize(MULTUM_ONE_LOBE_FITTED * size_of(width) * size_of(height));
  if (!journal_->read(found->second.offset,
                      {reinterpret_cast<std::uint8_t*>(fitted.data()), fitted.size() * sizeof(float)}))
    return false;
  rows_resumed_ += size_of(height);
  return true;
}

void FitJournal::add(int level, int first_row, int width, int height, const std::vector<float>& fitted) {
  const RecordHead head = {static_cast<std::uint32_t>(level), static_cast<std::uint32_t>(first_row),
                           static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)};
  MULTUM_CHECK(fitted.size() == float_count(head));
  journal_->add({bytes_of(head), bytes_of(fitted)});
}

}  // namespace multum
