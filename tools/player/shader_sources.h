// The files in shaders/, embedded at build time (embed_shaders.cmake), so that the player needs no path at
// run time.
#pragma once

namespace bakelight::player {

struct ShaderSource {
  const char* file_name;
  const char* text;
};

extern const ShaderSource kRadianceComp;
extern const ShaderSource kSurfaceVert;
extern const ShaderSource kSurfaceFrag;
extern const ShaderSource kFullscreenVert;
extern const ShaderSource kBackdropFrag;
extern const ShaderSource kResolveFrag;

}  // namespace bakelight::player
