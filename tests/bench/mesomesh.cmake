# CGAL's mesh processing is GPL-3: this program alone is linked with it, and is not installed.
bakelight_library(bakelight_bench_cgal
  SOURCES cgal_remesh.cpp
  PUBLIC bakelight_formats
  PRIVATE CGAL::CGAL Eigen3::Eigen
  OWN_FLAGS)
bakelight_benchmark(bench_mesomesh
  SOURCES bench_mesomesh.cpp synthesis_benchmarks.cpp
  LIBRARIES bakelight_mesomesh bakelight_mesomesh_synthesis bakelight_atlas bakelight_simplify bakelight_bench_cgal
            bakelight_formats_mesh_import TBB::tbb)
