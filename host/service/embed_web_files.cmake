# SPDX-License-Identifier: Apache-2.0
# cmake -DOUTPUT=embedded_web_files.cpp -DFOLDER=web -DFILES=a.js;b.css -P embed_web_files.cmake
# Writes every file's bytes as an array: a page may hold what would end a raw string, and CMake would take a semicolon
# or bracket of it for one of its own.
set(text "// SPDX-License-Identifier: Apache-2.0\n// Made by embed_web_files.cmake.\n")
string(APPEND text "#include \"host/service/http/web_files.h\"\n\nnamespace multum {\nnamespace {\n\n")
set(table "")
foreach(file IN LISTS FILES)
  file(READ "${FOLDER}/${file}" bytes HEX)
  string(REGEX REPLACE "[^A-Za-z0-9]" "_" name "${file}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${bytes}")
  string(APPEND text "constexpr char k_${name}[] = {\n    ${bytes}};\n\n")
  string(APPEND table "    {\"${file}\", {k_${name}, sizeof(k_${name})}},\n")
endforeach()
string(APPEND text "}  // namespace\n\n")
string(APPEND text "const std::vector<EmbeddedFile>& embedded_web_files() {\n")
string(APPEND text "  static const std::vector<EmbeddedFile> files = {\n${table}  };\n  return files;\n}\n\n")
string(APPEND text "}  // namespace multum\n")
file(WRITE "${OUTPUT}" "${text}")
