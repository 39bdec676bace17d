# Not a bench_*: `make bench` runs all of those; scripts/bench-large runs tools on what this writes.
add_executable(rippled_ball EXCLUDE_FROM_ALL rippled_ball.cpp)
target_link_libraries(rippled_ball PRIVATE bakelight_flags bakelight_formats_mesh bakelight_transport)
set_target_properties(rippled_ball PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
# The pictures of configs/assets/bunny_weave and its like.
add_executable(made_exemplar EXCLUDE_FROM_ALL made_exemplar.cpp)
target_link_libraries(made_exemplar PRIVATE bakelight_flags bakelight_formats_image bakelight_transport)
set_target_properties(made_exemplar PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
