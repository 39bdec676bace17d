bakelight_benchmark(bench_runtime
  SOURCES bench_runtime.cpp roofline.cpp
  LIBRARIES bakelight_transfer bakelight_simplify bakelight_formats_mesh_import bakelight_formats_image hwy::hwy TBB::tbb)
