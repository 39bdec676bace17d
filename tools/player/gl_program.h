// Compiles and links the embedded shaders.
#pragma once

#include <initializer_list>

#include "tools/player/gl_objects.h"
#include "tools/player/shader_sources.h"

namespace bakelight::player {

struct Stage {
  GLenum type;  // GL_VERTEX_SHADER, ...
  const ShaderSource& source;
};

// Throws Error(kNotAvailable) naming the shader, with the driver's log: the shaders are ours and valid, so it
// is this driver that cannot take them.
Program makeProgram(std::initializer_list<Stage> stages);

}  // namespace bakelight::player
