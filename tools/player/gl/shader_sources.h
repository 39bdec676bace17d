// The files in the shaders/ of each room, embedded at build time (embed_shaders.cmake), so that the player
// needs no path at run time.
#pragma once

namespace bakelight::player {

struct ShaderSource {
  const char* file_name;
  const char* text;
};

extern const ShaderSource kTableGlsl;
extern const ShaderSource kDiffuseComp;
extern const ShaderSource kMatrixComp;
extern const ShaderSource kOperatorComp;
extern const ShaderSource kVisibilityComp;
extern const ShaderSource kClusterComp;
extern const ShaderSource kSumLightsComp;
extern const ShaderSource kGlossyComp;
extern const ShaderSource kPixelTransferComp;
extern const ShaderSource kPixelLeavesComp;
extern const ShaderSource kPixelSumsComp;
extern const ShaderSource kPixelRowsComp;
extern const ShaderSource kPatchProjectComp;
extern const ShaderSource kPatchSurfaceVert;
extern const ShaderSource kPatchSurfaceFrag;
extern const ShaderSource kTranslucentVert;
extern const ShaderSource kTranslucentFrag;
extern const ShaderSource kSparseProductComp;
extern const ShaderSource kTexelEnteringComp;
extern const ShaderSource kKnotGatherComp;
extern const ShaderSource kTexelFilterComp;
extern const ShaderSource kTexelCombinationComp;
extern const ShaderSource kLightDepthFrag;
extern const ShaderSource kTexelLightComp;
extern const ShaderSource kProjectRowsComp;
extern const ShaderSource kProjectSumComp;
extern const ShaderSource kSurfaceVert;
extern const ShaderSource kSurfaceFrag;
extern const ShaderSource kDepthVert;
extern const ShaderSource kDepthFrag;
extern const ShaderSource kFullscreenVert;
extern const ShaderSource kBackdropFrag;
extern const ShaderSource kGroundVert;
extern const ShaderSource kGroundFrag;
extern const ShaderSource kReceiverComp;
extern const ShaderSource kResolveFrag;

}  // namespace bakelight::player
