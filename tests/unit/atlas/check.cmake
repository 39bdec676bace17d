bakelight_test(atlas_check_test
  SOURCES raster_test.cpp check_test.cpp
  LIBRARIES bakelight_atlas bakelight_stage bakelight_formats_mesh bakelight_transport
  DEPENDS atlas_check-tool)
