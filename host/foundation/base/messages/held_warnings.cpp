// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/messages/held_warnings.h"

#include <utility>

#include "host/foundation/base/messages/log_listener.h"

namespace multum {

HeldWarnings::HeldWarnings() : outer_(std::exchange(log_receivers().held, this)) {}

HeldWarnings::~HeldWarnings() { log_receivers().held = outer_; }

std::vector<std::string> HeldWarnings::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(held_, {});
}

bool HeldWarnings::keep(const std::string& message) {
  HeldWarnings* const held = log_receivers().held;
  if (held == nullptr) return false;
  const std::lock_guard lock(held->mutex_);
  held->held_.push_back(message);
  return true;
}

}  // namespace multum
