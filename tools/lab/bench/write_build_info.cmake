# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT, the source of build_info.h, with the commit of SOURCE_FOLDER and the COMPILER. An unchanged file is not
# written again, so that nothing is compiled again. Git must not search above SOURCE_FOLDER, or a copy inside another
# repository would get that repository's commit. Git must not take a lock, because commits during a build would then
# sometimes fail.
get_filename_component(ceiling ${SOURCE_FOLDER} DIRECTORY)
set(commit unknown)
# Documents may differ, because they are made one after another, and no figure depends on them.
set(git ${CMAKE_COMMAND} -E env GIT_OPTIONAL_LOCKS=0 GIT_CEILING_DIRECTORIES=${ceiling} git)
execute_process(COMMAND ${git} describe --always --abbrev=7 --exclude=*
  WORKING_DIRECTORY ${SOURCE_FOLDER} OUTPUT_VARIABLE described RESULT_VARIABLE failed
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT failed)
  set(commit ${described})
  execute_process(COMMAND ${git} diff --quiet HEAD -- . :!docs :!README.md
    WORKING_DIRECTORY ${SOURCE_FOLDER} RESULT_VARIABLE differs OUTPUT_QUIET ERROR_QUIET)
  if(differs)
    string(APPEND commit -dirty)
  endif()
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
// SPDX-License-Identifier: Apache-2.0
// Written by tools/lab/bench/write_build_info.cmake.
#include "tools/lab/bench/build_info.h"

namespace multum::bench {

std::string built_commit() { return "@commit@"; }
std::string compiler_name() { return "@COMPILER@"; }

}  // namespace multum::bench
]])
