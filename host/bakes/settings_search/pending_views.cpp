// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/pending_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/processes/viewer_process.h"

namespace multum {

PendingViews::PendingViews(std::string viewer, std::vector<std::string> common, std::string folder)
    : viewer_(std::move(viewer)), common_(std::move(common)), folder_(std::move(folder)) {}

void PendingViews::add(PendingView view, std::function<void(const DrawnView& drawn)> take) {
  const bool is_known =
      std::any_of(waiting_.begin(), waiting_.end(), [&](const Waiting& one) { return one.view.baked == view.baked; });
  if (!is_known) waiting_bytes_ += std::filesystem::file_size(view.baked);
  waiting_.push_back({std::move(view), std::move(take)});
}

std::string PendingViews::file(std::size_t number, const char* end) const {
  return fmt::format("{}/view_{}{}", folder_, number, end);
}

std::vector<std::string> PendingViews::command(std::size_t number) const {
  const PendingView& view = waiting_[number].view;
  std::vector<std::string> command = {view.baked, "-o", file(number, ".png"), "--report", file(number, ".json")};
  command.insert(command.end(), common_.begin(), common_.end());
  command.insert(command.end(), view.arguments.begin(), view.arguments.end());
  // For a small map, writing pictures takes a third of a view's time, so unneeded pictures are not written.
  if (view.shows_reference) command.insert(command.end(), {"--pictures", file(number, "")});
  else if (std::find(command.begin(), command.end(), "--compare") != command.end()) command.push_back("--alone");
  return command;
}

void PendingViews::draw(Progress* progress) {
  if (waiting_.empty()) return;
  nlohmann::json commands = nlohmann::json::array();
  for (std::size_t i = 0; i < waiting_.size(); ++i) commands.push_back(texts_of_paths(command(i)));
  const std::string list = folder_ + "/views.json";
  write_text_file(list, json_text(commands));
  run_viewer({viewer_, "each", list}, fmt::format("drawing {} pictures", waiting_.size()), progress);
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const bool is_sheet = waiting_[i].view.shows_reference;
    const nlohmann::json report = nlohmann::json::parse(bytes_of_file(file(i, ".json")));
    waiting_[i].take({report, bytes_of_file(file(i, is_sheet ? "_multum.png" : ".png")),
                      is_sheet ? bytes_of_file(file(i, "_reference.png")) : ""});
  }
  for (const Waiting& one : waiting_) {
    std::error_code ignored;  // a file that is shown in several views is removed only once
    std::filesystem::remove(one.view.baked, ignored);
  }
  waiting_.clear();
  waiting_bytes_ = 0;
}

}  // namespace multum
