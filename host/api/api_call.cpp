// SPDX-License-Identifier: Apache-2.0
#include "host/api/api_call.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <string>

#include "host/api/api_error.h"

namespace multum {

ApiCall::ApiCall(const multum_callbacks* callbacks) : scope_({this, nullptr}) {
  if (callbacks == nullptr) return;
  constexpr std::size_t kSizes[] = {offsetof(multum_callbacks, progress), offsetof(multum_callbacks, log),
                                    sizeof(multum_callbacks)};
  const bool is_known = callbacks->size >= sizeof(multum_callbacks) ||
                        std::find(std::begin(kSizes), std::end(kSizes), callbacks->size) != std::end(kSizes);
  if (!is_known)
    throw Error(ErrorCode::kUsage, "multum_callbacks: size is " + std::to_string(callbacks->size) +
                                       ", expected callbacks that MULTUM_CALLBACKS_INIT initialised");
  std::memcpy(&callbacks_, callbacks, std::min(callbacks->size, sizeof(callbacks_)));
  if (callbacks_.progress == nullptr) return;
  progress_ = std::make_unique<Progress>([this](const ProgressEvent& event) {
    const double share =
        event.units_total == 0
            ? -1.0
            : std::min(1.0, static_cast<double>(event.units_done) / static_cast<double>(event.units_total));
    return callbacks_.progress(callbacks_.user, event.stage.c_str(), share) == 0;
  });
}

void ApiCall::hear(LogKind kind, const std::string& line) {
  if (callbacks_.log == nullptr) return;
  const std::string message = api_message(line);
  const std::lock_guard lock(mutex_);
  const multum_log_kind kinds[] = {MULTUM_WARNING, MULTUM_INFO, MULTUM_VERBOSE};
  callbacks_.log(callbacks_.user, kinds[static_cast<int>(kind)], message.c_str());
}

}  // namespace multum
