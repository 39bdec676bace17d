bakelight_benchmark(bench_compression
  SOURCES bench_compression.cpp
  LIBRARIES bakelight_compression bakelight_shared_sums bakelight_formats_sum_grammar bakelight_transfer bakelight_simplify bakelight_formats_mesh_import
            bakelight_formats_light_rig TBB::tbb)
