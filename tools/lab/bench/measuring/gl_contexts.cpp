// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/gl_contexts.h"

#include "host/foundation/base/error.h"
#include "runtime_gl/context/egl_context.h"
#include "runtime_gl/context/headless_context.h"

namespace multum::bench {

nlohmann::ordered_json list_gl_contexts() {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const auto add = [&](const std::string& display, bool is_software, const std::string& description,
                       const std::string& reason) {
    rows.push_back(
        {{"display", display}, {"is_software", is_software}, {"description", description}, {"reason", reason}});
  };
  try {
    for (const gl::EglOffer& offer : gl::list_egl_offers())
      add("EGL, " + offer.display, offer.is_software, offer.description, offer.reason);
  } catch (const Error& error) {
    add("EGL", false, "", error.what());
  }
  try {
    add("OSMesa", true, gl::make_headless_context(gl::ContextBackend::kOsmesa)->description(), "");
  } catch (const Error& error) {
    add("OSMesa", true, "", error.what());
  }
  return rows;
}

}  // namespace multum::bench
