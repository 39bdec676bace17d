#include "tools/player/gl/gpu_timer.h"

#include <algorithm>

#include "tools/player/gl/gl_context.h"

namespace bakelight::player {
namespace {

thread_local GpuTimer* running = nullptr;  // for passes

Query stamp() {
  Query query = makeQuery(GL_TIMESTAMP);
  glQueryCounter(query.name(), GL_TIMESTAMP);
  return query;
}

// Nothing before it comes after it, and the other way round.
Query stampBetweenPasses() {
  glFlush();
  Query query = stamp();
  glFlush();
  return query;
}

double millisecondsBetween(const Query& begin, const Query& end) {
  GLint64 begin_ns = 0, end_ns = 0;
  glGetQueryObjecti64v(begin.name(), GL_QUERY_RESULT, &begin_ns);
  glGetQueryObjecti64v(end.name(), GL_QUERY_RESULT, &end_ns);
  return static_cast<double>(end_ns - begin_ns) * 1e-6;
}

}  // namespace

GpuTimer::~GpuTimer() {
  if (running == this) running = nullptr;
}

void GpuTimer::start(Of of) {
  passes_.clear();
  total_ = Span{"", stampBetweenPasses(), {}};
  running = of == Of::kPasses ? this : nullptr;
}

GpuTimes GpuTimer::finish() {
  running = nullptr;
  GpuTimes times;
  if (!total_) return times;
  total_->end = stamp();
  times.total_ms = millisecondsBetween(total_->begin, total_->end);
  for (const Span& pass : passes_) {
    const double pass_ms = millisecondsBetween(pass.begin, pass.end);
    const auto known = std::ranges::find(times.passes_ms, pass.name, &std::pair<std::string, double>::first);
    if (known != times.passes_ms.end())
      known->second += pass_ms;
    else
      times.passes_ms.emplace_back(pass.name, pass_ms);
  }
  total_.reset();
  passes_.clear();
  throwIfGlFailed("reading the GPU's times");
  return times;
}

GpuPass::GpuPass(const char* name) : timer_(running) {
  if (timer_ == nullptr) return;
  index_ = timer_->passes_.size();
  timer_->passes_.push_back({name, stampBetweenPasses(), {}});
}

GpuPass::~GpuPass() {
  if (timer_ != nullptr && timer_ == running) timer_->passes_[index_].end = stampBetweenPasses();
}

}  // namespace bakelight::player
