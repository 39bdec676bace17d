bakelight_test(atlas_convex_boundary_test
  SOURCES convex_boundary_test.cpp
  LIBRARIES bakelight_atlas bakelight_atlas_exact)
