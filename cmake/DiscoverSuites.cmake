# Writes OUTPUT, a file for ctest: one test for each suite of the GoogleTest program TEST.
execute_process(COMMAND ${TEST} --gtest_list_tests OUTPUT_VARIABLE listed COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( |\n)" suites "${listed}")
set(lines "")
foreach(suite IN LISTS suites)
  string(REGEX REPLACE "[\n ]" "" suite "${suite}")
  string(REGEX REPLACE "\\.$" "" suite "${suite}")
  string(APPEND lines "add_test([==[${suite}]==] [==[${TEST}]==] [==[--gtest_filter=${suite}.*]==])\n"
    "set_tests_properties([==[${suite}]==] PROPERTIES WORKING_DIRECTORY [==[${FOLDER}]==] TIMEOUT 600)\n")
endforeach()
if(NOT lines)
  message(FATAL_ERROR "${TEST} has no tests")
endif()
file(WRITE ${OUTPUT} "${lines}")
