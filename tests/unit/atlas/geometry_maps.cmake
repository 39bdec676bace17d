bakelight_test(atlas_geometry_maps_test
  SOURCES geometry_maps_test.cpp geometry_maps_border_test.cpp
  LIBRARIES bakelight_atlas bakelight_atlas_exact bakelight_transport TBB::tbb)
