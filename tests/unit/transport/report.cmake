bakelight_test(transport_report_test
  SOURCES flip_test.cpp near_light_test.cpp vertex_shading_steps_test.cpp
  LIBRARIES bakelight_made_packs TBB::tbb)
