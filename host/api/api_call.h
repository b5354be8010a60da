// SPDX-License-Identifier: Apache-2.0
// Connects a call of multum.h to its callbacks: progress, cancelling and the log.
#pragma once

#include <memory>
#include <mutex>

#include "host/api/multum.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// While the object exists, receives the log of the calling thread and of the threads that work for it.
class ApiCall : private LogListener {
 public:
  /// `callbacks` is null for a call without callbacks. Throws Error(kUsage) for a struct of unknown size.
  explicit ApiCall(const multum_callbacks* callbacks);
  ApiCall(const ApiCall&) = delete;
  ApiCall& operator=(const ApiCall&) = delete;

  /// Returns the Progress for the work, or null if nobody listens.
  Progress* progress() { return progress_.get(); }

 private:
  void hear(LogKind kind, const std::string& line) override;

  multum_callbacks callbacks_ = MULTUM_CALLBACKS_INIT;
  std::mutex mutex_;
  std::unique_ptr<Progress> progress_;
  LogScope scope_;
};

}  // namespace multum
