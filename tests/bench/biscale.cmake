bakelight_benchmark(bench_biscale
  SOURCES bench_biscale.cpp biscale_subject.cpp biscale_images.cpp
  LIBRARIES bakelight_rtt bakelight_transfer bakelight_packing bakelight_reference bakelight_patch bakelight_formats_image TBB::tbb)
target_compile_definitions(bench_biscale PRIVATE BAKELIGHT_PATCHES_DIR="${CMAKE_SOURCE_DIR}/configs/patches")
