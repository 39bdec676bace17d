bakelight_test(transport_report_test
  SOURCES near_light_test.cpp vertex_shading_steps_test.cpp
  LIBRARIES bakelight_made_packs TBB::tbb)
