#include "tools/player/gl_program.h"

#include <string>
#include <vector>

#include "formats/error.h"

namespace bakelight::player {
namespace {

Error refused(const std::string& shader, const std::string& step, const std::string& log) {
  return Error(ExitStatus::kNotAvailable, {"", "shader " + shader, ""},
               "the OpenGL driver " + step + ": " + log, "a driver with complete OpenGL 4.5 core",
               "updating the driver, or Mesa's llvmpipe");
}

Shader compile(const Stage& stage) {
  Shader shader(glCreateShader(stage.type));
  glShaderSource(shader.name(), 1, &stage.source.text, nullptr);
  glCompileShader(shader.name());
  GLint compiled = GL_FALSE, log_length = 0;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  glGetShaderiv(shader.name(), GL_INFO_LOG_LENGTH, &log_length);
  std::string log(static_cast<std::size_t>(log_length), '\0');
  glGetShaderInfoLog(shader.name(), log_length, &log_length, log.data());
  log.resize(static_cast<std::size_t>(log_length));
  throw refused(stage.source.file_name, "does not compile it", log);
}

}  // namespace

Program makeProgram(std::initializer_list<Stage> stages) {
  Program program(glCreateProgram());
  std::string names;
  for (const Stage& stage : stages) {
    // An attached shader lives on in its program when its own name goes.
    glAttachShader(program.name(), compile(stage).name());
    names += (names.empty() ? "" : " + ") + std::string(stage.source.file_name);
  }
  glLinkProgram(program.name());
  GLint linked = GL_FALSE, log_length = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  glGetProgramiv(program.name(), GL_INFO_LOG_LENGTH, &log_length);
  std::string log(static_cast<std::size_t>(log_length), '\0');
  glGetProgramInfoLog(program.name(), log_length, &log_length, log.data());
  log.resize(static_cast<std::size_t>(log_length));
  throw refused(names, "does not link it", log);
}

}  // namespace bakelight::player
