// SPDX-License-Identifier: Apache-2.0
#include "tools/command_line/help_files.h"

#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/version.h"
#include "tools/command_line/command_page.h"
#include "tools/command_line/man_pages.h"

namespace multum {

std::string command_page_of(const CLI::App& program) {
  const CommandText text = describe(program);
  return (text.name == "multum" ? command_page_head() : "") + command_page_part(text);
}

int write_man_pages(const CLI::App& program, const std::string& folder) {
  make_folder(folder);
  const auto pages = man_pages(describe(program), MULTUM_VERSION);
  for (const auto& [name, text] : pages) write_text_file(folder + "/" + name, text);
  return static_cast<int>(pages.size());
}

std::string completion_of(const CLI::App& program, const std::string& shell) {
  return completion_script(describe(program), shell);
}

}  // namespace multum
