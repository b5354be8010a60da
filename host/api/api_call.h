// SPDX-License-Identifier: Apache-2.0
// Connects a call of multum.h to its callbacks: progress, cancelling and the log.
#pragma once

#include <memory>
#include <mutex>

#include "host/api/multum.h"
#include "host/foundation/base/messages/log_listener.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Receives the log of the calling thread, and of the threads that work for it, during the object's life.
class ApiCall : private LogListener {
 public:
  /// `callbacks`: null for a call without callbacks. Throws Error(kUsage) for a struct of unknown size.
  explicit ApiCall(const multum_callbacks* callbacks);
  ApiCall(const ApiCall&) = delete;
  ApiCall& operator=(const ApiCall&) = delete;

  /// Progress for the work; null if nobody listens.
  Progress* progress() { return progress_.get(); }

 private:
  void hear(LogKind kind, const std::string& line) override;

  multum_callbacks callbacks_ = MULTUM_CALLBACKS_INIT;
  std::mutex mutex_;
  std::unique_ptr<Progress> progress_;
  LogScope scope_;
};

}  // namespace multum
