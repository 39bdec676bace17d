bakelight_benchmark(bench_simplify
  SOURCES bench_simplify.cpp
  LIBRARIES bakelight_simplify bakelight_formats_mesh_import meshoptimizer::meshoptimizer TBB::tbb)
