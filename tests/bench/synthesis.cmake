bakelight_benchmark(bench_synthesis
  SOURCES bench_synthesis.cpp
  LIBRARIES bakelight_mesomesh_synthesis bakelight_formats_mesh_import TBB::tbb)
