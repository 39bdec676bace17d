bakelight_test(atlas_charts_test
  SOURCES chart_test.cpp charting_test.cpp free_boundary_test.cpp make_atlas_test.cpp untangling_test.cpp
  LIBRARIES bakelight_atlas bakelight_transport bakelight_formats_mesh TBB::tbb
  SPLIT)
