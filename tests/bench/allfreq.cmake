bakelight_benchmark(bench_allfreq
  SOURCES bench_allfreq.cpp biscale_subject.cpp biscale_images.cpp
  LIBRARIES bakelight_coded_sums bakelight_rtt bakelight_transfer bakelight_packing bakelight_reference bakelight_patch bakelight_formats_image
            bakelight_formats_light_rig TBB::tbb)
target_compile_definitions(bench_allfreq PRIVATE BAKELIGHT_PATCHES_DIR="${CMAKE_SOURCE_DIR}/configs/patches")
