# SPDX-License-Identifier: Apache-2.0
# Tests of the readers (MULTUM_READERS_ONLY), for tools/cross/readers. They run in the emulator of the toolchain file.
set(tests ${CMAKE_SOURCE_DIR}/tests)
set(unit ${tests}/unit)
add_executable(printed_map ${tests}/cross/printed_map.cpp)
target_link_libraries(printed_map PRIVATE multum_flags multum_readers)

# Tests that write no files run on every system. The others write baked files with multum's own writers, damage them and
# read them.
add_executable(reader_test ${tests}/api/api_shading_test.cpp
  ${unit}/formats/asset/gpu_bytes_test.cpp ${unit}/formats/asset/quantize_test.cpp
  ${unit}/formats/asset/representation_test.cpp ${unit}/foundation/base/checksum_test.cpp
  ${unit}/foundation/base/path_text_test.cpp ${CMAKE_SOURCE_DIR}/host/lab/reference/movmf_rounding.cpp
  ${CMAKE_SOURCE_DIR}/host/lab/reference/spherical_harmonics.cpp)
if(NOT WIN32)
  target_sources(reader_test PRIVATE ${unit}/formats/asset/damaged_chunk_test.cpp
    ${unit}/formats/asset/format_formula_test.cpp
    ${unit}/formats/asset/gmm_file_test.cpp ${unit}/formats/asset/header_hash_test.cpp
    ${unit}/formats/asset/material_file_test.cpp ${unit}/formats/asset/moment_file_test.cpp
    ${unit}/formats/asset/movmf_finest_test.cpp ${unit}/formats/asset/movmf_mipmap_test.cpp
    ${unit}/formats/asset/movmf_refusal_test.cpp ${unit}/formats/asset/movmf_verify_test.cpp
    ${unit}/formats/asset/movmf_writer_test.cpp ${unit}/formats/asset/sh_file_test.cpp
    ${unit}/foundation/base/content_hash_test.cpp ${unit}/foundation/base/exr_chunks_test.cpp
    ${unit}/foundation/base/regular_file_test.cpp)
endif()
target_link_libraries(reader_test PRIVATE multum_flags multum_readers multum_codec_decoder OpenEXR::OpenEXR ZLIB::ZLIB
  fmt::fmt nlohmann_json::nlohmann_json GTest::gtest_main)
target_compile_definitions(reader_test PRIVATE MULTUM_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
target_compile_options(reader_test PRIVATE $<$<CONFIG:Release>:-O1>)
# Death tests run the program again in a child process, which qemu-user cannot do.
set(left_out "")
if(CMAKE_CROSSCOMPILING_EMULATOR)
  set(left_out ":*DeathTest*")
endif()
add_test(NAME reader_test COMMAND reader_test "--gtest_filter=-ApiShadingTest.*${left_out}")
add_test(NAME shading_test COMMAND reader_test "--gtest_filter=ApiShadingTest.*")
set_tests_properties(reader_test shading_test PROPERTIES TIMEOUT 3600)

# The text that the build of this machine's processor has printed, and the files that it has read.
set(MULTUM_PRINTED_MAPS "" CACHE PATH "A folder that same_map_test.py bake has filled; \"\": the test is left out")
if(MULTUM_PRINTED_MAPS)
  add_test(NAME same_map COMMAND ${Python3_EXECUTABLE} ${tests}/cross/same_map_test.py compare ${MULTUM_PRINTED_MAPS}
    ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:printed_map>)
endif()
