// SPDX-License-Identifier: Apache-2.0
// Implements multum completion and multum man, which write shell completion and manual pages of multum and multum-view.
#include <cstdio>
#include <filesystem>
#include <memory>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/shown_text.h"
#include "tools/command_line/help_files.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct ManOptions {
  std::string folder;
  bool markdown = false, json = false;
};

// Runs the same command of multum-view, which describes its own command line. Returns "" if multum-view is not
// installed.
std::string answer_of_viewer(const std::vector<std::string>& words) {
  std::vector<std::string> command = {find_viewer()};
  command.insert(command.end(), words.begin(), words.end());
  try {
    const ChildResult result = run_child(command);
    return result.exit_code == 0 ? result.output : "";
  } catch (const Error&) {
    return "";
  }
}

int run_man(const CLI::App& program, const ManOptions& o) {
  if (o.markdown) {
    write_shown(stdout, command_page_of(program));
    return 0;
  }
  if (o.folder.empty()) throw CLI::RequiredError("--output");
  const int count = write_man_pages(program, o.folder);
  answer_of_viewer({"man", "-o", std::filesystem::absolute(o.folder).string()});
  if (o.json) print_json({{"output", path_json(o.folder)}});
  else
    print_shown(stdout, "%s: written: %d pages for multum, and one for each command of multum-view\n", o.folder.c_str(),
                count);
  return 0;
}

}  // namespace

void add_help_commands(CLI::App& app, int* exit_code) {
  auto shell = std::make_shared<std::string>();
  CLI::App* completion =
      app.add_subcommand("completion", "print a script that completes commands and options in a shell");
  completion->add_option("shell", *shell, "shell for which the script is printed")
      ->required()
      ->check(CLI::IsMember(kShells));
  completion->footer(
      "Examples:\n"
      "  multum completion bash > ~/.local/share/bash-completion/completions/multum\n"
      "  multum completion zsh >> ~/.zshrc\n"
      "  multum completion fish > ~/.config/fish/completions/multum.fish");
  completion->callback([&app, shell, exit_code] {
    write_shown(stdout, completion_of(app, *shell) + answer_of_viewer({"completion", *shell}));
    *exit_code = 0;
  });

  auto o = std::make_shared<ManOptions>();
  CLI::App* man = app.add_subcommand("man", "write manual pages of multum and multum-view");
  man->add_option("-o,--output", o->folder, "folder to write the pages to");
  man->add_flag("--markdown", o->markdown, "print the part of docs/reference/commands.md about multum")->group("");
  add_json_option(*man, o->json);
  man->footer("Example:\n  multum man -o ~/.local/share/man/man1");
  man->callback([&app, o, exit_code] { *exit_code = run_man(app, *o); });
}

}  // namespace multum
