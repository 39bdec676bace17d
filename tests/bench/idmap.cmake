bakelight_benchmark(bench_idmap
  SOURCES bench_idmap.cpp
  LIBRARIES bakelight_idmap bakelight_mesomesh bakelight_atlas bakelight_simplify bakelight_formats_mesh bakelight_formats_mesh_import
            bakelight_transport flann TBB::tbb)
