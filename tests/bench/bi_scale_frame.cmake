bakelight_benchmark(bench_bi_scale_frame
  SOURCES bench_bi_scale_frame.cpp
  LIBRARIES bakelight_player bakelight_transport)
