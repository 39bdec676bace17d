#include "tools/player/gl/gl_context.h"

// epoxy's headers come first: they replace the system's.
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

#include "formats/error.h"

namespace bakelight::player {
namespace {

// The first error since it was last asked for. One thread owns the context, and messages arrive synchronously
// on it.
thread_local std::string first_error;

void onGlMessage(GLenum, GLenum type, GLuint, GLenum severity, GLsizei length, const GLchar* text,
                 const void*) {
  const std::string message = length < 0 ? text : std::string(text, static_cast<std::size_t>(length));
  if (type == GL_DEBUG_TYPE_ERROR) {
    if (first_error.empty()) first_error = message;
  } else if (severity == GL_DEBUG_SEVERITY_HIGH || severity == GL_DEBUG_SEVERITY_MEDIUM) {
    spdlog::warn("OpenGL: {}", message);
  }
}

std::string nameOfError(GLenum code) {
  switch (code) {
    case GL_INVALID_ENUM:
      return "invalid enumeration";
    case GL_INVALID_VALUE:
      return "invalid value";
    case GL_INVALID_OPERATION:
      return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "invalid framebuffer";
    case GL_OUT_OF_MEMORY:
      return "out of memory";
    default:
      return "error " + std::to_string(code);
  }
}

struct Platform {
  std::string name;
  EGLDisplay display;
};

bool hasExtension(const char* extensions, const std::string& name) {
  return extensions != nullptr &&
         (" " + std::string(extensions) + " ").find(" " + name + " ") != std::string::npos;
}

// Graphics cards first. Mesa lists its software renderer among the devices, too, and says so.
std::vector<Platform> devicePlatforms() {
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
  std::vector<Platform> hardware, software;
  for (EGLint i = 0; i < count; ++i) {
    const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
    if (hasExtension(eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
      software.push_back({"software device " + std::to_string(i), display});
    else
      hardware.push_back({"device " + std::to_string(i), display});
  }
  hardware.insert(hardware.end(), software.begin(), software.end());
  return hardware;
}

std::vector<Platform> platforms() {
  std::vector<Platform> found;
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool named_platforms = hasExtension(extensions, "EGL_EXT_platform_base");
  const bool devices_are_listed = hasExtension(extensions, "EGL_EXT_device_base") ||
                                  (hasExtension(extensions, "EGL_EXT_device_enumeration") &&
                                   hasExtension(extensions, "EGL_EXT_device_query"));
  if (named_platforms && hasExtension(extensions, "EGL_EXT_platform_device") && devices_are_listed)
    found = devicePlatforms();
  if (named_platforms && hasExtension(extensions, "EGL_MESA_platform_surfaceless"))
    found.push_back({"surfaceless",
                     eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)});
  found.push_back({"default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return found;
}

EGLContext makeCurrentContext(EGLDisplay display) {
  const std::array<EGLint, 9> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                            4,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            5,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_CONTEXT_OPENGL_DEBUG,
                                            wantsGlMessages() ? EGL_TRUE : EGL_FALSE,
                                            EGL_NONE};
  const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
  if (context == EGL_NO_CONTEXT) return EGL_NO_CONTEXT;
  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE) return context;
  eglDestroyContext(display, context);
  return EGL_NO_CONTEXT;
}

// Empty if it worked, else what went wrong.
std::string tryPlatform(EGLDisplay display, EGLContext& context) {
  if (display == EGL_NO_DISPLAY) return "no display";
  if (eglInitialize(display, nullptr, nullptr) != EGL_TRUE) return "cannot be initialised";
  std::string problem;
  const char* extensions = eglQueryString(display, EGL_EXTENSIONS);
  if (!hasExtension(extensions, "EGL_KHR_no_config_context") ||
      !hasExtension(extensions, "EGL_KHR_surfaceless_context"))
    problem = "no contexts without a surface";
  else if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE)
    problem = "no desktop OpenGL";
  else if ((context = makeCurrentContext(display)) == EGL_NO_CONTEXT)
    problem = "no OpenGL 4.5 core";
  if (!problem.empty()) eglTerminate(display);
  return problem;
}

}  // namespace

bool wantsGlMessages() {
  const char* wish = std::getenv("BAKELIGHT_GL_DEBUG");
  return wish != nullptr && std::string(wish) == "1";
}

void watchGlMessages() {
  first_error.clear();
  if (!wantsGlMessages()) return;
  glEnable(GL_DEBUG_OUTPUT);
  glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
  glDebugMessageCallback(onGlMessage, nullptr);
}

void throwIfGlFailed(const std::string& doing) {
  std::string message = std::exchange(first_error, {});
  for (GLenum code = glGetError(); code != GL_NO_ERROR; code = glGetError())
    if (message.empty()) message = nameOfError(code);
  if (message.empty()) return;
  throw Error(ExitStatus::kNotAvailable, {"", glRendererName(), ""},
              "OpenGL failed while " + doing + ": " + message, "",
              "a smaller picture or pack if memory ran out, else another driver; BAKELIGHT_GL_DEBUG=1 in the "
              "environment brings the driver's own words");
}

std::string glRendererName() {
  const auto text = [](GLenum name) {
    const GLubyte* value = glGetString(name);
    return value == nullptr ? std::string("unknown") : std::string(reinterpret_cast<const char*>(value));
  };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

HeadlessContext::HeadlessContext() {
  constexpr const char* kRemedy = "installing libegl1 and libgl1-mesa-dri, or the graphics card's driver";
  if (!epoxy_has_egl())
    throw Error(ExitStatus::kNotAvailable, {"", "EGL", ""}, "libEGL.so.1 is not installed", "", kRemedy);
  std::string problems;
  for (const Platform& platform : platforms()) {
    EGLContext context = EGL_NO_CONTEXT;
    const std::string problem = tryPlatform(platform.display, context);
    if (problem.empty()) {
      display_ = platform.display;
      context_ = context;
      watchGlMessages();
      return;
    }
    problems += (problems.empty() ? "" : "; ") + platform.name + ": " + problem;
  }
  throw Error(ExitStatus::kNotAvailable, {"", "EGL", ""},
              "no OpenGL without a window on this machine (" + problems + ")", "OpenGL 4.5 core through EGL",
              kRemedy);
}

HeadlessContext::~HeadlessContext() {
  glDebugMessageCallback(nullptr, nullptr);
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

}  // namespace bakelight::player
