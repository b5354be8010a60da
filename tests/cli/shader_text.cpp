// SPDX-License-Identifier: Apache-2.0
#include "tests/cli/shader_text.h"

#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <vector>

#include "tests/cli/program.h"

namespace multum::testing {

// The C preprocessor treats GLSL like C, except for directives that these texts do not use.
std::string reached_code(const std::string& fragment, const std::string& scratch) {
  write_bytes(scratch, fragment);
  const ProgramResult preprocessed = run_program({MULTUM_COMPILER, "-E", "-P", "-x", "c", scratch});
  EXPECT_EQ(preprocessed.exit_code, 0) << preprocessed.err;
  const std::string& text = preprocessed.out;
  std::map<std::string, std::string> functions;
  static const std::regex kDefinition(R"(\w+\s+(main|multum_\w+)\s*\([^(){};]*\)\s*\{)");
  for (std::sregex_iterator i(text.begin(), text.end(), kDefinition), none; i != none; ++i) {
    const auto begin = static_cast<std::size_t>(i->position());
    std::size_t end = begin + static_cast<std::size_t>(i->length());
    for (int depth = 1; depth > 0 && end < text.size(); ++end)
      depth += text[end] == '{' ? 1 : text[end] == '}' ? -1 : 0;
    functions[(*i)[1]] += text.substr(begin, end - begin) + "\n";  // overloads of a name are kept together
  }
  std::string code;
  std::set<std::string> reached;
  std::vector<std::string> open = {"main"};
  static const std::regex kCall(R"((\w+)\s*\()");
  while (!open.empty()) {
    const std::string name = open.back();
    open.pop_back();
    const auto found = functions.find(name);
    if (found == functions.end() || !reached.insert(name).second) continue;
    code += found->second;
    for (std::sregex_iterator i(found->second.begin(), found->second.end(), kCall), none; i != none; ++i)
      open.push_back((*i)[1]);
  }
  EXPECT_TRUE(reached.contains("main"));
  return code;
}

}  // namespace multum::testing
