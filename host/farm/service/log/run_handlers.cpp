// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/log/run_handlers.h"

#include <exception>

namespace multum {

void run_handlers(boost::asio::io_context& io, LogSeverity severity, const std::string& what) {
  for (;;) {
    try {
      io.run();
      return;
    } catch (const std::exception& error) {
      service_log(severity, 0, what + ": " + error.what());
    }
  }
}

}  // namespace multum
