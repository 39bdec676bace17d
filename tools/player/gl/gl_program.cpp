#include "tools/player/gl/gl_program.h"

#include <utility>

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
  std::vector<const char*> texts = {"#version 450 core\n", stage.definitions.c_str()};
  for (const ShaderSource& part : stage.parts) texts.push_back(part.text);
  glShaderSource(shader.name(), static_cast<GLsizei>(texts.size()), texts.data(), nullptr);
  glCompileShader(shader.name());
  GLint compiled = GL_FALSE, log_length = 0;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  glGetShaderiv(shader.name(), GL_INFO_LOG_LENGTH, &log_length);
  std::string log(static_cast<std::size_t>(log_length), '\0');
  glGetShaderInfoLog(shader.name(), log_length, &log_length, log.data());
  log.resize(static_cast<std::size_t>(log_length));
  throw refused(stage.parts.back().file_name, "does not compile it", log);
}

}  // namespace

Program makeProgram(const std::vector<Stage>& stages) {
  Program program(glCreateProgram());
  std::string names;
  for (const Stage& stage : stages) {
    // An attached shader lives on in its program when its own name goes.
    glAttachShader(program.name(), compile(stage).name());
    names += (names.empty() ? "" : " + ") + std::string(stage.parts.back().file_name);
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

Program makeComputeProgram(std::vector<ShaderSource> parts, std::string definitions) {
  return makeProgram({{GL_COMPUTE_SHADER, std::move(parts), std::move(definitions)}});
}

}  // namespace bakelight::player
