# Builds the library for packs as somebody who has neither the tools' libraries nor GoogleTest, installs it, and builds and
# runs the example with nothing but what was installed.
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(absent "")
foreach(package glfw3 CGAL GTest benchmark OpenImageIO OpenEXR PNG assimp embree OpenMesh TBB CLI11 spdlog meshoptimizer hwy)
  list(APPEND absent -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
file(REMOVE_RECURSE ${FOLDER})
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${FOLDER}/library -DBAKELIGHT_TOOLS=OFF -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_INSTALL_PREFIX=${FOLDER}/installed ${absent})
run(${CMAKE_COMMAND} --build ${FOLDER}/library)
run(${CMAKE_COMMAND} --install ${FOLDER}/library)

# From a copy, so that no header of the source tree is found by chance.
file(COPY ${SOURCE}/examples/read_pack DESTINATION ${FOLDER})
run(${CMAKE_COMMAND} -G Ninja -S ${FOLDER}/read_pack -B ${FOLDER}/example -DCMAKE_PREFIX_PATH=${FOLDER}/installed
    -DCMAKE_CXX_COMPILER=${COMPILER})
run(${CMAKE_COMMAND} --build ${FOLDER}/example)
run(${FOLDER}/example/read_pack ${SOURCE}/tests/unit/formats/golden/pack-v2-cpca-uint8-table.glb)
foreach(line "grid: 9 vertices, 8 triangles, order 2, interreflected" "reflects as table")
  string(FIND "${output}" "${line}" place)
  if(place EQUAL -1)
    message(FATAL_ERROR "the example does not say '${line}':\n${output}")
  endif()
endforeach()
file(STRINGS ${SOURCE}/examples/read_pack/main.cpp lines)
list(LENGTH lines count)
if(count GREATER_EQUAL 60)
  message(FATAL_ERROR "the example has ${count} lines: it should be short")
endif()
