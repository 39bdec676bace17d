bakelight_test(sampling_test
  SOURCES random_test.cpp single_ray_test.cpp
  LIBRARIES bakelight_rays)
