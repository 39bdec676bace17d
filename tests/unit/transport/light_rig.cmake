bakelight_test(light_rig_test
  SOURCES polygon_light_test.cpp windowing_test.cpp sky_test.cpp light_rig_test.cpp emitters_test.cpp punctual_light_test.cpp lighting_test.cpp
  LIBRARIES bakelight_rays TBB::tbb)
