bakelight_benchmark(bench_fit
  SOURCES bench_fit.cpp
  LIBRARIES bakelight_transfer bakelight_simplify bakelight_formats_mesh_import bakelight_formats_image TBB::tbb)
