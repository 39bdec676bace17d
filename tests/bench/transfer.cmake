bakelight_benchmark(bench_transfer
  SOURCES bench_transfer.cpp
  LIBRARIES bakelight_transfer bakelight_simplify bakelight_formats_mesh_import embree TBB::tbb)
