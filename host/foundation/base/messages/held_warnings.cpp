// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/messages/held_warnings.h"

#include <mutex>
#include <utility>

namespace multum {
namespace {

std::mutex g_held_mutex;
HeldWarnings* g_held = nullptr;

}  // namespace

HeldWarnings::HeldWarnings() {
  const std::lock_guard lock(g_held_mutex);
  outer_ = std::exchange(g_held, this);
}

HeldWarnings::~HeldWarnings() {
  const std::lock_guard lock(g_held_mutex);
  g_held = outer_;
}

std::vector<std::string> HeldWarnings::take() {
  const std::lock_guard lock(g_held_mutex);
  return std::exchange(held_, {});
}

bool HeldWarnings::keep(const std::string& message) {
  const std::lock_guard lock(g_held_mutex);
  if (g_held != nullptr) g_held->held_.push_back(message);
  return g_held != nullptr;
}

}  // namespace multum
