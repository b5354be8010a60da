# SPDX-License-Identifier: Apache-2.0
# cmake -DOUTPUT=openapi.cpp -DFILE=openapi.json -DHEADER=host/service/http/openapi.h -DFUNCTION=openapi_json
#   -P embed_text.cmake
# Writes a function that returns the file's text, cut into pieces because compilers need not take long literals.
file(READ "${FILE}" text)
set(source "// SPDX-License-Identifier: Apache-2.0\n// Made by embed_text.cmake.\n#include \"${HEADER}\"\n\n")
string(APPEND source "namespace multum {\n\nconst std::string& ${FUNCTION}() {\n  static const std::string text =")
string(LENGTH "${text}" length)
set(begin 0)
while(begin LESS length)
  string(SUBSTRING "${text}" ${begin} 4000 piece)
  string(APPEND source "\n      R\"MULTUM_TEXT(${piece})MULTUM_TEXT\"")
  math(EXPR begin "${begin} + 4000")
endwhile()
string(APPEND source ";\n  return text;\n}\n\n}  // namespace multum\n")
file(WRITE "${OUTPUT}" "${source}")
