#include "tools/player/window.h"

// epoxy's header comes first: it replaces the system's.
#include <epoxy/gl.h>
#include <GLFW/glfw3.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "formats/error.h"
#include "formats/image.h"
#include "tools/player/controls.h"
#include "tools/player/gl/gl_context.h"
#include "tools/player/renderer.h"

namespace bakelight::player {
namespace {

Error noWindow(const std::string& what) {
  const char* words = nullptr;
  glfwGetError(&words);
  return Error(ExitStatus::kNotAvailable, {"", "window", ""},
               what + (words == nullptr ? "" : ": " + std::string(words)), "a display and OpenGL 4.5 core",
               "--image PICTURE.png, which needs no display");
}

// GLFW's initialisation and one window with a current context.
class GlfwWindow {
 public:
  GlfwWindow(int width_px, int height_px, const std::string& title) {
    if (glfwInit() != GLFW_TRUE) throw noWindow("no windows on this machine");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, wantsGlMessages() ? GLFW_TRUE : GLFW_FALSE);
    window_ = glfwCreateWindow(width_px, height_px, title.c_str(), nullptr, nullptr);
    if (window_ == nullptr) {
      const Error error = noWindow("no window with OpenGL");
      glfwTerminate();
      throw error;
    }
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    watchGlMessages();
  }
  ~GlfwWindow() { glfwTerminate(); }
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GLFWwindow* get() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
};

// Turns events into settings, and settings into frames; a frame is drawn only after something changed, or
// while lights move.
class Session {
 public:
  Session(GLFWwindow* window, const formats::Pack& pack, const transport::Lighting& lighting,
          const formats::FrameSettings& settings, const SurroundingsOptions& surroundings)
      : window_(window),
        name_(pack.name.empty() ? "bakelight" : pack.name),
        start_(settings),
        settings_(settings),
        renderer_(pack, lighting, surroundings) {
    glfwSetWindowUserPointer(window, this);
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int, int) { of(w).rememberCursor(); });
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) { of(w).onCursor(x, y); });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double steps) { of(w).onScroll(steps); });
    glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
      if (action == GLFW_PRESS) of(w).onKey(key);
    });
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { of(w).changed_ = true; });
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { of(w).changed_ = true; });
  }

  void play() {
    while (glfwWindowShouldClose(window_) == GLFW_FALSE) {
      if (changed_ || playing()) drawFrame();
      if (screenshot_wanted_) saveScreenshot();
      playing() ? glfwPollEvents() : glfwWaitEvents();
    }
  }

 private:
  static Session& of(GLFWwindow* window) { return *static_cast<Session*>(glfwGetWindowUserPointer(window)); }

  void rememberCursor() { glfwGetCursorPos(window_, &cursor_x_, &cursor_y_); }

  void onCursor(double x, double y) {
    const double dx = x - cursor_x_, dy = y - cursor_y_;
    cursor_x_ = x;
    cursor_y_ = y;
    if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
      dragOrbit(settings_, dx, dy);
    else if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_RIGHT) == GLFW_PRESS)
      dragLight(settings_, dx, dy);
    else if (glfwGetMouseButton(window_, GLFW_MOUSE_BUTTON_MIDDLE) == GLFW_PRESS)
      dragObject(settings_, dx, dy);
    else
      return;
    changed_ = true;
  }

  void onScroll(double steps) {
    zoom(settings_, steps);
    changed_ = true;
  }

  void onKey(int key) {
    if (key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(window_, GLFW_TRUE);
    if (key == GLFW_KEY_S) screenshot_wanted_ = true;
    if (key == GLFW_KEY_SPACE) hold(!held_);
    if (key == GLFW_KEY_R) {
      settings_ = start_;
      changed_ = true;
    }
  }

  bool playing() const { return renderer_.moves() && !held_ && settings_.width_px > 0; }

  void hold(bool held) {
    held_ = held;
    last_frame_s_ = glfwGetTime();
  }

  // Time goes on from frame to frame, and stands still while they are held.
  void advanceTime() {
    const double now_s = glfwGetTime();
    if (playing()) settings_.time_s += now_s - last_frame_s_;
    last_frame_s_ = now_s;
  }

  void drawFrame() {
    changed_ = false;
    advanceTime();
    glfwGetFramebufferSize(window_, &settings_.width_px, &settings_.height_px);
    if (settings_.width_px == 0 || settings_.height_px == 0) return;  // minimised
    const auto start = std::chrono::steady_clock::now();
    renderer_.draw(settings_);
    renderer_.target().resolveForDisplay(0, renderer_.exposure(settings_));
    glFinish();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    glfwSwapBuffers(window_);
    glfwSetWindowTitle(window_, fmt::format("{} - {:.1f} ms", name_, time.count()).c_str());
  }

  // What the last frame showed. Not done in the callback: an error must not fly through GLFW, which is C.
  void saveScreenshot() {
    screenshot_wanted_ = false;
    if (renderer_.target().widthPx() == 0) return;
    std::string path;
    for (int number = 1; path.empty() || std::filesystem::exists(path); ++number)
      path = fmt::format("{}-{:03}.png", std::filesystem::path(name_).filename().string(), number);
    formats::writePng(path, renderer_.target().displayImage(renderer_.exposure(settings_)));
    spdlog::info("saved {}", path);
  }

  GLFWwindow* window_;
  std::string name_;
  formats::FrameSettings start_, settings_;
  Renderer renderer_;
  double cursor_x_ = 0, cursor_y_ = 0;
  double last_frame_s_ = glfwGetTime();
  bool changed_ = true, screenshot_wanted_ = false, held_ = false;
};

}  // namespace

void playInWindow(const formats::Pack& pack, const transport::Lighting& lighting,
                  const formats::FrameSettings& settings, const SurroundingsOptions& surroundings) {
  const GlfwWindow window(settings.width_px, settings.height_px, pack.name);
  spdlog::info("{}", glRendererName());
  spdlog::info("{}", kControlsHelp);
  Session(window.get(), pack, lighting, settings, surroundings).play();
}

}  // namespace bakelight::player
