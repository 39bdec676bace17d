bakelight_benchmark(bench_bicluster
  SOURCES bench_bicluster.cpp roofline.cpp
  LIBRARIES bakelight_bicluster bakelight_player bakelight_transfer bakelight_simplify bakelight_formats_mesh_import hwy::hwy TBB::tbb)
