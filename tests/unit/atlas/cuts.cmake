bakelight_test(atlas_cuts_test
  SOURCES cuts_test.cpp
  LIBRARIES bakelight_atlas)
