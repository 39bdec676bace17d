bakelight_test(atlas_packing_test
  SOURCES packing_test.cpp
  LIBRARIES bakelight_atlas TBB::tbb
  SPLIT)
