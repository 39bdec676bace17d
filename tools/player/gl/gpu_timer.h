// Times on the GPU, by GL's timer queries: of all that is between start() and finish(), or of each pass in
// it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/player/gl/gl_objects.h"

namespace bakelight::player {

struct GpuTimes {
  double total_ms = 0;
  // In the order in which passes began; passes of one name are added up.
  std::vector<std::pair<std::string, double>> passes_ms;
};

// One at a time on a context's thread.
class GpuTimer {
 public:
  enum class Of {
    kTotal,   // passes are left alone
    kPasses,  // each is flushed before the next begins, as renderers that sort work by tiles mix passes
              // otherwise: the total is more than without
  };

  GpuTimer() = default;
  ~GpuTimer();
  GpuTimer(const GpuTimer&) = delete;
  GpuTimer& operator=(const GpuTimer&) = delete;

  void start(Of of);
  // Waits until the GPU has come this far.
  GpuTimes finish();

 private:
  friend class GpuPass;
  struct Span {
    std::string name;
    Query begin, end;
  };

  std::optional<Span> total_;
  std::vector<Span> passes_;
};

// The commands during its life are a pass of the timer that runs on this thread; without one that is for
// passes, it does nothing.
class GpuPass {
 public:
  explicit GpuPass(const char* name);
  ~GpuPass();
  GpuPass(const GpuPass&) = delete;
  GpuPass& operator=(const GpuPass&) = delete;

 private:
  GpuTimer* timer_;
  std::size_t index_ = 0;
};

}  // namespace bakelight::player
