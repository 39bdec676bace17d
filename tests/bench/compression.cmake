bakelight_benchmark(bench_compression
  SOURCES bench_compression.cpp
  LIBRARIES bakelight_coded_sums bakelight_transfer bakelight_simplify bakelight_formats_mesh_import
            bakelight_formats_light_rig TBB::tbb)
