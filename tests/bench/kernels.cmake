bakelight_benchmark(bench_kernels
  SOURCES bench_kernels.cpp translucency_error.cpp roofline.cpp
  LIBRARIES bakelight_rays bakelight_kernels bakelight_atlas bakelight_simplify bakelight_formats_mesh_import bakelight_formats_tensors)
# Not a bench_*: `make figures` runs it.
add_executable(mean_free_path EXCLUDE_FROM_ALL mean_free_path.cpp translucency_error.cpp)
target_link_libraries(mean_free_path PRIVATE bakelight_flags bakelight_kernels bakelight_atlas bakelight_report bakelight_formats_tensors)
set_target_properties(mean_free_path PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
