// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/json_output.h"

#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"

namespace multum {

CLI::Option* add_json_option(CLI::App& command, bool& json) {
  return command.add_flag("--json", json, "print the result as one JSON document, and no other text, on stdout")
      ->group(kCommonGroup);
}

void print_json(const OrderedJson& json) { write_shown(stdout, escaped_json(json_text(json, 2)) + "\n"); }

OrderedJson parsed(const std::string& json_text) { return OrderedJson::parse(json_text); }

OrderedJson path_json(const std::string& path) { return text_of_path(path); }

}  // namespace multum
