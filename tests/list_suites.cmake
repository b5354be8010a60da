# SPDX-License-Identifier: Apache-2.0
# Writes one ctest entry for each suite of a GoogleTest program: cmake -DPROGRAM=... -DOUTPUT=...
# -DSLOW="suite suite" -DEMULATOR=... -P list_suites.cmake. The suites in SLOW are labelled slow; the others are
# labelled fast. EMULATOR is the program that runs a program of another processor or system, or "".
cmake_policy(VERSION 3.25)
set(runner "")
if(EMULATOR)
  set(runner "[=[${EMULATOR}]=] ")
endif()
execute_process(COMMAND ${EMULATOR} ${PROGRAM} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY
  TIMEOUT 60)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( |\n)" suites "${listed}")  # lines of cases are indented
separate_arguments(SLOW)
# GoogleTest's last lines when every case was skipped. When a case failed, other lines follow.
set(skipped "\\[  PASSED  \\] 0 tests\\.\n(\\[  SKIPPED \\] [^\n]*\n*)+$")
set(entries "")
foreach(suite ${suites})
  string(REGEX REPLACE "[ \n]|\\.[ \n]" "" suite "${suite}")
  set(label fast)
  string(REGEX REPLACE "^.*/" "" name "${suite}")  # removes the prefix of an instantiation
  if(name IN_LIST SLOW)
    set(label slow)
  endif()
  string(APPEND entries "add_test([=[${suite}]=] ${runner}[=[${PROGRAM}]=] [=[--gtest_filter=${suite}.*]=])\n"
    "set_tests_properties([=[${suite}]=] PROPERTIES LABELS ${label}"
    " SKIP_REGULAR_EXPRESSION [=[${skipped}]=])\n")
endforeach()
file(WRITE ${OUTPUT} "${entries}")
