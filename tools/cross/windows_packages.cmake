# SPDX-License-Identifier: Apache-2.0
# Finds the libraries that tools/cross/windows_libraries has built for Windows. Debian's packages of headers have the
# include folder /usr/include, which also holds the headers of Linux, so copies of their headers are used.
set(MULTUM_WINDOWS_LIBRARIES "${CMAKE_SOURCE_DIR}/build/windows-libraries" CACHE PATH
  "The folder that tools/cross/windows_libraries has made")
list(APPEND CMAKE_PREFIX_PATH ${MULTUM_WINDOWS_LIBRARIES})
include_directories(SYSTEM ${MULTUM_WINDOWS_LIBRARIES}/include)
add_compile_definitions(_FILE_OFFSET_BITS=64 _USE_MATH_DEFINES NOMINMAX)
set(ZLIB_USE_STATIC_LIBS ON)
foreach(headers glm::glm nlohmann_json::nlohmann_json Eigen3::Eigen fmt::fmt)
  add_library(${headers} INTERFACE IMPORTED)
endforeach()
target_compile_definitions(fmt::fmt INTERFACE FMT_HEADER_ONLY)
