// Compiles and links the embedded shaders.
#pragma once

#include <string>
#include <vector>

#include "tools/player/gl/gl_objects.h"
#include "tools/player/gl/shader_sources.h"

namespace bakelight::player {

// One shader: its parts in order, behind "#version 450 core" and `definitions` (lines of "#define NAME
// VALUE"), by which one source serves several precisions and storages.
struct Stage {
  GLenum type;  // GL_VERTEX_SHADER, ...
  std::vector<ShaderSource> parts;
  std::string definitions = {};
};

// Throws Error(kNotAvailable) naming the shader, with the driver's log: the shaders are ours and valid, so it
// is this driver that cannot take them.
Program makeProgram(const std::vector<Stage>& stages);
Program makeComputeProgram(std::vector<ShaderSource> parts, std::string definitions = "");

}  // namespace bakelight::player
