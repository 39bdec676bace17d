bakelight_benchmark(bench_rtt
  SOURCES bench_rtt.cpp
  LIBRARIES bakelight_rtt embree TBB::tbb)
target_compile_definitions(bench_rtt PRIVATE BAKELIGHT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
