// SPDX-License-Identifier: Apache-2.0
// Draws baked maps of a sweep by multum-view, many in one child process: of a small map, starting a process with a GL
// driver takes longer than drawing. Baked files wait until they are drawn, so that only so many bytes of them do.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum {

/// One way to draw a baked map.
struct PendingView {
  std::string baked;                   // the file
  std::vector<std::string> arguments;  // of multum-view, but for the file, -o, --report and what all have in common
  bool shows_reference = false;        // DrawnView has it, too
};

struct DrawnView {
  const nlohmann::json& report;  // of multum-view
  std::string picture;           // PNG bytes
  std::string reference;         // the same of the reference, where it was asked for
};

class PendingViews {
 public:
  /// `common`: arguments of every view. Files are made in `folder`, and stay there.
  PendingViews(std::string viewer, std::vector<std::string> common, std::string folder);

  /// `take` is called when it has been drawn, in the order of add().
  void add(PendingView view, std::function<void(const DrawnView& drawn)> take);
  /// Bytes of the baked files that wait.
  std::uint64_t waiting_bytes() const { return waiting_bytes_; }
  /// Draws all that wait and removes their baked files. Throws what run_viewer() does.
  void draw(Progress* progress);

 private:
  struct Waiting {
    PendingView view;
    std::function<void(const DrawnView& drawn)> take;
  };
  std::string file(std::size_t number, const char* end) const;
  std::vector<std::string> command(std::size_t number) const;

  const std::string viewer_;
  const std::vector<std::string> common_;
  const std::string folder_;
  std::vector<Waiting> waiting_;
  std::uint64_t waiting_bytes_ = 0;
};

}  // namespace multum
