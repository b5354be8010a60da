// SPDX-License-Identifier: Apache-2.0
// The scripts avoid the names `options` and `commands`, which are special parameters in zsh. All three scripts
// determine the command from the words that have been typed so far. The key of a command's options consists of its
// words, such as "multum jobs list". The key of choices consists of the command and the option.
#include "tools/command_line/completion_scripts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

using Visit = std::function<void(const CommandText&)>;

void for_each_command(const CommandText& command, const Visit& visit) {
  visit(command);
  for (const CommandText& one : command.commands) for_each_command(one, visit);
}

// Puts a text in single quotes, for bash and zsh. fish reads it in the same way if the text has no quotes.
std::string quoted(std::string text) {
  for (std::size_t at = text.find('\''); at != std::string::npos; at = text.find('\'', at + 4))
    text.replace(at, 1, "'\\''");
  return "'" + text + "'";
}

std::string quoted_for_fish(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return result + "'";
}

std::string one_line(std::string text) {
  text = text.substr(0, text.find("\n\n"));
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string function_name(const CommandText& program) {
  std::string name = "_" + program.name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::vector<std::string> option_names(const CommandText& command) {
  std::vector<std::string> names;
  for (const OptionText& option : command.options)
    for (const std::string& name : {option.short_name, option.long_name})
      if (!name.empty()) names.push_back(name);
  return names;
}

// Returns `case` patterns for all commands except the program itself.
std::string command_patterns(const CommandText& program) {
  std::string text;
  for_each_command(program, [&](const CommandText& one) {
    if (&one != &program) text += (text.empty() ? "" : "|") + quoted(one.words);
  });
  return text;
}

// Returns the arms of a `case` over "COMMAND:OPTION", one per option with choices. `arm` receives the pattern and the
// choices.
std::string choice_arms(const CommandText& program,
                        const std::function<std::string(const std::string&, const std::string&)>& arm) {
  std::string text;
  for_each_command(program, [&](const CommandText& one) {
    for (const OptionText& option : one.options) {
      if (option.choices.empty() || option.long_name.empty()) continue;
      std::string pattern = quoted(one.words + ":" + option.long_name);
      if (!option.short_name.empty()) pattern += "|" + quoted(one.words + ":" + option.short_name);
      text += arm(pattern, fmt::format("{}", fmt::join(option.choices, " ")));
    }
  });
  return text;
}

std::string bash_script(const CommandText& program) {
  std::string arms;
  for_each_command(program, [&](const CommandText& one) {
    std::vector<std::string> commands;
    for (const CommandText& child : one.commands) commands.push_back(child.name);
    arms += fmt::format("    {}) options={} commands={} ;;\n", quoted(one.words),
                        quoted(fmt::format("{}", fmt::join(option_names(one), " "))),
                        quoted(fmt::format("{}", fmt::join(commands, " "))));
  });
  const std::string choices = choice_arms(program, [](const std::string& pattern, const std::string& words) {
    return fmt::format("    {}) COMPREPLY=($(compgen -W {} -- \"$current\")); return ;;\n", pattern, quoted(words));
  });
  return fmt::format(
      R"(# Completion of {0} for bash. Load it: source <({0} completion bash)
{1}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
  local command={2} options= commands= i
  # bash splits --option=value at the equals sign.
  if [[ $current == = ]]; then current=
  elif [[ $previous == = ]]; then previous=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$command ${{COMP_WORDS[i]}}" in
    {3}) command="$command ${{COMP_WORDS[i]}}" ;;
    esac
  done
  case "$command:$previous" in
{4}    *) ;;
  esac
  case "$command" in
{5}  esac
  if [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
  else
    COMPREPLY=($(compgen -W "$commands" -- "$current") $(compgen -f -- "$current"))
  fi
}}
complete -o filenames -F {1} {0}
)",
      program.name, function_name(program), quoted(program.words), command_patterns(program), choices, arms);
}

std::string zsh_script(const CommandText& program) {
  std::string arms;
  for_each_command(program, [&](const CommandText& one) {
    arms += fmt::format("    ({})\n      option_list=(", quoted(one.words));
    for (const OptionText& option : one.options)
      for (const std::string& name : {option.short_name, option.long_name})
        if (!name.empty()) arms += "\n        " + quoted(name + ":" + one_line(option.help));
    arms += ")\n      command_list=(";
    for (const CommandText& child : one.commands)
      arms += "\n        " + quoted(child.name + ":" + one_line(child.help));
    arms += ") ;;\n";
  });
  const std::string choices = choice_arms(program, [](const std::string& pattern, const std::string& words) {
    return fmt::format("    ({}) compadd -- {}; return ;;\n", pattern, words);
  });
  return fmt::format(
      R"(#compdef {0}
# Completion of {0} for zsh. Load it after compinit: source <({0} completion zsh)
{1}() {{
  local line={2} i
  local -a option_list command_list
  for ((i = 2; i < CURRENT; ++i)); do
    case "$line $words[i]" in
    ({3}) line="$line $words[i]" ;;
    esac
  done
  case "$line:$words[CURRENT-1]" in
{4}    (*) ;;
  esac
  case "$line" in
{5}  esac
  if [[ $words[CURRENT] == -* ]]; then
    _describe -o option option_list
  else
    (( $#command_list )) && _describe command command_list
    _files
  fi
}}
compdef {1} {0}
)",
      program.name, function_name(program), quoted(program.words), command_patterns(program), choices, arms);
}

std::string fish_script(const CommandText& program) {
  const std::string function = "_" + function_name(program) + "_command";
  std::string known, lines;
  for_each_command(program, [&](const CommandText& one) {
    if (&one != &program) known += " " + quoted_for_fish(one.words);
    const std::string head = fmt::format("complete -c {} -n {}", program.name,
                                         quoted_for_fish(fmt::format("test ({}) = \"{}\"", function, one.words)));
    for (const CommandText& child : one.commands)
      lines += fmt::format("{} -a {} -d {}\n", head, child.name, quoted_for_fish(one_line(child.help)));
    for (const OptionText& option : one.options) {
      if (option.long_name.empty()) continue;
      lines += head + " -l " + option.long_name.substr(2);
      if (!option.short_name.empty()) lines += " -s " + option.short_name.substr(1);
      if (!option.choices.empty())
        lines += " -x -a " + quoted_for_fish(fmt::format("{}", fmt::join(option.choices, " ")));
      else if (!option.is_flag) lines += " -r";
      lines += " -d " + quoted_for_fish(one_line(option.help)) + "\n";
    }
  });
  return fmt::format(
      R"(# Completion of {0} for fish. Load it: {0} completion fish | source
function {1}
  set -l command {2}
  set -l known{3}
  for word in (commandline -opc)[2..-1]
    contains -- "$command $word" $known; and set command "$command $word"
  end
  echo $command
end
{4})",
      program.name, function, program.name, known, lines);
}

}  // namespace

std::string completion_script(const CommandText& program, const std::string& shell) {
  if (shell == "bash") return bash_script(program);
  if (shell == "zsh") return zsh_script(program);
  MULTUM_CHECK(shell == "fish");
  return fish_script(program);
}

}  // namespace multum
