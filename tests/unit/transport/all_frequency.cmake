bakelight_test(all_frequency_test
  SOURCES all_frequency_shading_test.cpp
  LIBRARIES bakelight_transport bakelight_bicluster)
