bakelight_benchmark(bench_pack_open
  SOURCES bench_pack_open.cpp
  LIBRARIES bakelight_formats_pack bakelight_transport)
