# One way to declare a library, a tool, a test and a benchmark, so that all rooms share flags and habits.

option(BAKELIGHT_WERROR "Treat warnings as errors" ON)
option(BAKELIGHT_UNITY "Compile up to 8 files of a target as one: a third of a clean build's time" ON)
set(BAKELIGHT_SANITIZE "" CACHE STRING "Sanitizers, for example address,undefined")

add_library(bakelight_flags INTERFACE)
target_include_directories(bakelight_flags INTERFACE ${CMAKE_SOURCE_DIR})
# -ffp-contract=off: a fused multiply-add rounds once where the portable path rounds twice; stage outputs must
# not depend on which instructions a processor has.
# -ffile-prefix-map: a binary, and with it the cache key of a stage, does not depend on where it was built.
target_compile_options(bakelight_flags INTERFACE
  -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -ffp-contract=off
  -ffile-prefix-map=${CMAKE_SOURCE_DIR}=. -ffile-prefix-map=${CMAKE_BINARY_DIR}=build)
# GCC 12 takes "text" + std::string at -O3 for an overflow, an overlap or an access past the end (GCC bug 105651,
# mended in 13).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(bakelight_flags INTERFACE -Wno-restrict -Wno-stringop-overflow
    -Wno-stringop-overread -Wno-array-bounds)
endif()
if(BAKELIGHT_WERROR)
  target_compile_options(bakelight_flags INTERFACE -Werror)
endif()
if(BAKELIGHT_SANITIZE)
  target_compile_options(bakelight_flags INTERFACE -fsanitize=${BAKELIGHT_SANITIZE} -fno-omit-frame-pointer
    -fno-sanitize-recover=all)
  target_link_options(bakelight_flags INTERFACE -fsanitize=${BAKELIGHT_SANITIZE})
endif()

# Which files go together is found at configuration: a "redefinition" of a name that a file has for itself, after an
# edit, is mended by configuring again.
function(bakelight_unity target)
  if(NOT BAKELIGHT_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources INCLUDE REGEX "^[^/].*\\.cpp$")
  execute_process(COMMAND ${CMAKE_SOURCE_DIR}/cmake/unity-groups ${CMAKE_CURRENT_SOURCE_DIR} ${sources}
                  OUTPUT_VARIABLE groups COMMAND_ERROR_IS_FATAL ANY)
  foreach(source_and_group IN LISTS groups)
    string(REPLACE "=" ";" source_and_group ${source_and_group})
    list(GET source_and_group 0 source)
    list(GET source_and_group 1 group)
    # Named after the target too, as a file may be a part of two.
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${target}_${group})
  endforeach()
  # clang-tidy reads the files of a group together too, and is right that one includes the others.
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP
    UNITY_BUILD_CODE_BEFORE_INCLUDE "// NOLINTNEXTLINE(bugprone-suspicious-include)")
endfunction()

# Headers that take seconds to read are read twice in a build: once for the product and once for the tests, whose code
# is optimized less. Project headers are not among them, so that a file that lacks one does not compile.
set(precompiled_headers <algorithm> <array> <atomic> <cmath> <filesystem> <fstream> <functional> <iostream> <map>
  <memory> <mutex> <numeric> <optional> <random> <set> <span> <sstream> <string> <thread> <unordered_map> <variant>
  <vector> <Eigen/Dense> <nlohmann/json.hpp>)
file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/precompiled.cpp CONTENT "")
add_library(bakelight_precompiled OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
target_link_libraries(bakelight_precompiled PRIVATE bakelight_flags Eigen3::Eigen nlohmann_json::nlohmann_json)
target_precompile_headers(bakelight_precompiled PRIVATE ${precompiled_headers})

# Asserts of GoogleTest are much code that runs once: -O1 compiles them in two thirds of -O3's time.
add_library(bakelight_test_flags INTERFACE)
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(bakelight_test_flags INTERFACE -O1)
endif()
if(BAKELIGHT_TESTS)
  add_library(bakelight_test_precompiled OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(bakelight_test_precompiled PRIVATE
    bakelight_flags bakelight_test_flags Eigen3::Eigen nlohmann_json::nlohmann_json GTest::gtest GTest::gmock)
  target_precompile_headers(bakelight_test_precompiled PRIVATE ${precompiled_headers} <gtest/gtest.h> <gmock/gmock.h>)
endif()

# Code that runs once, around the work: two thirds of the time to compile.
set(cold_options $<$<CONFIG:Release>:-O1>)

# bakelight_library(NAME SOURCES a.cpp ... [PUBLIC libs] [PRIVATE libs] [OWN_FLAGS] [COLD]); OWN_FLAGS: a library that it
# uses brings flags for the compiler, which a precompiled header would have to share; COLD: see above.
function(bakelight_library name)
  cmake_parse_arguments(ARG "OWN_FLAGS;COLD" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC $<BUILD_INTERFACE:bakelight_flags> ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  if(NOT ARG_OWN_FLAGS)
    target_precompile_headers(${name} REUSE_FROM bakelight_precompiled)
  endif()
  if(ARG_COLD)
    target_compile_options(${name} PRIVATE ${cold_options})
  endif()
  bakelight_unity(${name})
endfunction()

# bakelight_module(NAME SOURCES a.cpp ... LIBRARIES libs): a library that programs load when they need it
# (formats/module.h). It is compiled from sources, as the libraries above are not made to be shared.
function(bakelight_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_library(bakelight_${name} MODULE ${ARG_SOURCES})
  target_link_libraries(bakelight_${name} PRIVATE bakelight_flags ${ARG_LIBRARIES})
  target_link_options(bakelight_${name} PRIVATE LINKER:--no-undefined)
  set_target_properties(bakelight_${name} PROPERTIES
    PREFIX "" OUTPUT_NAME ${name} LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/bakelight)
  # Where tools look for it: beside their folder.
  install(TARGETS bakelight_${name} LIBRARY DESTINATION lib/bakelight)
endfunction()

# All executables, without tests and benchmarks: what `make pipeline` needs.
add_custom_target(tools)

# bakelight_executable(NAME SOURCES main.cpp LIBRARIES libs): lands in <build>/bin. Its own sources are compiled as COLD.
function(bakelight_executable name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  # The target is called NAME-tool, as `pack` or `transfer` would be taken for words of the build system.
  add_executable(${name}-tool ${ARG_SOURCES})
  set_target_properties(${name}-tool PROPERTIES OUTPUT_NAME ${name})
  target_link_libraries(${name}-tool PRIVATE bakelight_flags ${ARG_LIBRARIES})
  target_precompile_headers(${name}-tool REUSE_FROM bakelight_precompiled)
  target_compile_options(${name}-tool PRIVATE ${cold_options})
  add_dependencies(tools ${name}-tool)
  install(TARGETS ${name}-tool)
endfunction()

# bakelight_test(NAME SOURCES a_test.cpp ... LIBRARIES libs [DEPENDS targets] [SPLIT]): one GoogleTest program a room.
# Each suite becomes a ctest, so that what its tests share is made once; SPLIT makes each TEST one, named Suite.Test,
# where tests run for many seconds.
function(bakelight_test name)
  cmake_parse_arguments(ARG "SPLIT" "" "SOURCES;LIBRARIES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE
    bakelight_flags bakelight_test_flags ${ARG_LIBRARIES} GTest::gtest GTest::gmock GTest::gtest_main)
  target_precompile_headers(${name} REUSE_FROM bakelight_test_precompiled)
  bakelight_unity(${name})
  target_compile_definitions(${name} PRIVATE
    BAKELIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}" BAKELIGHT_BIN_DIR="${CMAKE_RUNTIME_OUTPUT_DIRECTORY}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(ARG_DEPENDS)
    add_dependencies(${name} ${ARG_DEPENDS})
  endif()
  if(ARG_SPLIT)
    include(GoogleTest)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 600)
    return()
  endif()
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${name}_suites.cmake)
  add_custom_command(TARGET ${name} POST_BUILD BYPRODUCTS ${suites} VERBATIM
    COMMAND ${CMAKE_COMMAND} -DTEST=$<TARGET_FILE:${name}> -DFOLDER=${CMAKE_CURRENT_BINARY_DIR} -DOUTPUT=${suites}
            -P ${CMAKE_SOURCE_DIR}/cmake/DiscoverSuites.cmake)
  set(include_file ${CMAKE_CURRENT_BINARY_DIR}/${name}_include.cmake)
  file(WRITE ${include_file}
    "if(EXISTS \"${suites}\")\n  include(\"${suites}\")\nelse()\n  add_test(${name}_NOT_BUILT ${name}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${include_file})
endfunction()

# bakelight_benchmark(NAME SOURCES x.cpp LIBRARIES libs): a Google Benchmark program in <build>/bin.
function(bakelight_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE bakelight_flags ${ARG_LIBRARIES} benchmark::benchmark)
  target_precompile_headers(${name} REUSE_FROM bakelight_precompiled)
  target_compile_definitions(${name} PRIVATE BAKELIGHT_DATA_DIR="${CMAKE_BINARY_DIR}/assets")
endfunction()
