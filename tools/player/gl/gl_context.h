// A current OpenGL 4.5 core context without a window, and the watch over what the driver reports.
#pragma once

#include <string>

namespace bakelight::player {

// Whether the driver is asked to tell what it thinks of our calls: with BAKELIGHT_GL_DEBUG=1 in the
// environment. Not otherwise, since drivers warn of harmless things, and their debug contexts cost time.
bool wantsGlMessages();

// If so, collects the current context's KHR_debug messages: errors are kept for throwIfGlFailed, the rest of
// medium or high severity goes to the log. Call once after a context was made current, which should be a
// debug context then.
void watchGlMessages();

// Throws Error(kNotAvailable) if a GL call has failed since the last call of this function, with the driver's
// words where it is asked for them. `doing` completes "OpenGL failed while ...".
void throwIfGlFailed(const std::string& doing);

// "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 (Core Profile) Mesa 22.3.6": for the log.
std::string glRendererName();

// Made current on the calling thread by the constructor, released by the destructor. Tries EGL's hardware
// devices, then those that are software, then the surfaceless platform, then the default display. Throws
// Error(kNotAvailable) with what each of them said.
class HeadlessContext {
 public:
  HeadlessContext();
  ~HeadlessContext();
  HeadlessContext(const HeadlessContext&) = delete;
  HeadlessContext& operator=(const HeadlessContext&) = delete;

 private:
  void* display_ = nullptr;  // EGLDisplay and EGLContext, which EGL itself defines as void*
  void* context_ = nullptr;
};

}  // namespace bakelight::player
