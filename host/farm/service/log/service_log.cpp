// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/log/service_log.h"

#include <unistd.h>

#include <array>
#include <nlohmann/json.hpp>

#include "host/farm/service/log/wall_clock.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"

namespace multum {

void service_log(LogSeverity severity, std::int64_t job, const std::string& message) {
  constexpr std::array kNames = {"info", "warning", "error"};
  nlohmann::ordered_json line;
  line["time"] = time_text(wall_clock_ms());
  line["level"] = kNames.at(static_cast<std::size_t>(severity));
  if (job != 0) line["job"] = job;
  line["message"] = text_of_message(message);
  const std::string text = escaped_json(line.dump()) + "\n";
  // Each line is one write, so that lines of several threads are not mixed.
  [[maybe_unused]] const ssize_t ignored = ::write(2, text.data(), text.size());
}

}  // namespace multum
