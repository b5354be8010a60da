// SPDX-License-Identifier: Apache-2.0
// Draws the baked maps of a sweep with multum-view. One child process draws many maps, because starting a process with
// a GL driver takes longer than drawing a small map. Baked files are kept until they are drawn, and their total size is
// limited.
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
  std::string baked;                   // the baked file
  std::vector<std::string> arguments;  // options of multum-view, without the file, -o, --report and common options
  bool shows_reference = false;        // also return the reference's picture
};

struct DrawnView {
  const nlohmann::json& report;  // report of multum-view
  std::string picture;           // PNG bytes
  std::string reference;         // PNG bytes of the reference, if requested
};

class PendingViews {
 public:
  /// `common` holds the arguments for every view. Files are written to `folder` and are not removed.
  PendingViews(std::string viewer, std::vector<std::string> common, std::string folder);

  /// Calls `take` when the view has been drawn, in the order of add().
  void add(PendingView view, std::function<void(const DrawnView& drawn)> take);
  /// Total size of the baked files that are not yet drawn.
  std::uint64_t waiting_bytes() const { return waiting_bytes_; }
  /// Draws all waiting views and removes their baked files. Throws the same errors as run_viewer().
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
