// SPDX-License-Identifier: Apache-2.0
// Implements the part of `multum doctor` that checks whether a service works.
#include <cstdlib>

#include "host/farm/service/http/http_client.h"
#include "host/foundation/base/error.h"
#include "tools/multum/commands.h"
#include "tools/multum/doctor_checks.h"

namespace multum {

DoctorFindings service_findings(const std::string& server) {
  const char* const from_environment = std::getenv("MULTUM_SERVER");
  const bool is_named = !server.empty() || from_environment != nullptr;
  const std::string address = !server.empty()               ? server
                              : from_environment != nullptr ? from_environment
                                                            : "http://127.0.0.1:8470";
  HttpPatience patience;
  patience.connecting = patience.answer = std::chrono::seconds(5);
  try {
    HttpClient(address, "", patience).ask("GET", "/healthz");
    return {{DoctorState::kFine, "service", address + ": answers", ""}};
  } catch (const Error& error) {
    if (!is_named)
      return {
          {DoctorState::kAbsent, "service", address + ": no service is running", "`multum serve` starts a service."}};
    return {{DoctorState::kFailure, "service", error.what(),
             "Start the service there (`multum serve`), or correct --server or MULTUM_SERVER."}};
  }
}

}  // namespace multum
