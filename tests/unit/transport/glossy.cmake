bakelight_test(transport_glossy_test
  SOURCES triple_product_test.cpp glossy_test.cpp microfacet_test.cpp glossy_evaluator_test.cpp vertex_shading_test.cpp bi_scale_shading_test.cpp patch_lookup_test.cpp texture_frames_test.cpp
  LIBRARIES bakelight_rays TBB::tbb hwy::hwy)
