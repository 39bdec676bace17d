// Error and run time of every variant of a plan.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/report/errors.h"
#include "tools/report/flip.h"
#include "tools/report/pareto.h"
#include "tools/report/plan.h"
#include "tools/report/recently_used.h"
#include "tools/report/renderer.h"
#include "tools/report/sources.h"
#include "tools/report/timing.h"
#include "tools/report/window.h"

namespace bakelight::report {

struct ErrorFigures {
  double rel_rmse = 0, p99 = 0, flip = 0, coverage_error = 0;
};

struct CauseError {
  std::string cause;
  double rel_rmse = 0;
};

struct LightWindow {
  std::string light;  // of the views
  WindowChoice choice;
};

struct VariantFigures {
  ErrorFigures errors;                     // over all views
  std::vector<ErrorFigures> view_errors;   // a view
  std::vector<CauseError> causes;          // a link of the chain
  std::vector<LightWindow> windows;        // of each light, where they are measured
  Spread light_change_ms, view_change_ms;  // on the CPU
  std::uint64_t bytes = 0;
  double bake_s = 0, bake_cpu_s = 0;
  std::size_t vertices = 0;

  double frame_ms() const { return light_change_ms.median + view_change_ms.median; }
  // Of the cause "left_out", where the chain has it.
  std::optional<double> leftOutError() const;
};

// Indices of variants, by rising cost.
struct Fronts {
  std::vector<std::size_t> frame_ms, bytes, bake_s;
};

// A way to store a transfer matrix in a pixel basis.
struct StorageMethod {
  std::string name, parameters;
  double share = 0;  // of the exact sums' bytes, that it was given; 0: as many as it takes
  std::uint64_t bytes = 0, operations = 0;
  Spread product_ms = {};
  std::vector<double> incident_errors = {};  // a view: relative RMS of L* over all rows, from exact rows
  std::vector<double> picture_errors = {};   // a view: relative RMSE of the picture, from the reference
};

struct StorageFigures {
  std::uint64_t rows = 0, entries = 0, dense_bytes = 0;
  std::vector<StorageMethod> methods;
};

struct Evaluation {
  std::vector<double> noise;             // a view: standard error of the reference, relative to its rms
  std::vector<VariantFigures> variants;  // as in the plan
  Fronts fronts;
  std::optional<StorageFigures>
      storage;  // of the first variant whose transfer is in a pixel basis, and exact
};

// Holds the references of the plan and makes pictures to compare with them. Plan and sources must outlive it.
class Evaluator {
 public:
  // Reads the references. Throws Error(kBadInput) as referenceFrom does, and for a picture that does not say
  // where its camera stood ("bakelight:eye", "bakelight:target", "bakelight:fov_deg").
  Evaluator(const Plan& plan, const Sources& sources);

  // Times are the medians of `rounds` ≥ 1; `storage`: whether ways to store a matrix in a pixel basis are compared. `advanced` is called after each variant's errors, and after each
  // variant's times. Throws Error(kBadInput) naming the pack that shares no wholly covered pixel with a
  // reference.
  Evaluation evaluate(int rounds, const std::function<void()>& advanced, bool storage = true);

  using Pictures = std::vector<Reference>;  // a view
  std::shared_ptr<const Pictures> picturesOf(const PlanFile& pack);
  // Nothing for a pack whose light is not in spherical harmonics.
  std::optional<WindowChoice> windowOf(const PlanFile& pack, std::size_t view);
  const Pictures& truth() const { return truth_; }
  double exposure(std::size_t view) const { return exposures_[view]; }

 private:
  std::shared_ptr<const Pictures> picturesOf(const ChainLink& link);
  void measureErrors(const PlanVariant& variant, VariantFigures& figures);
  void measureCauses(const PlanVariant& variant, VariantFigures& figures);
  double flip(const Picture& picture, std::size_t view, std::size_t& pixels) const;
  void measureStorage(Evaluation& evaluation, const std::function<void()>& advanced);
  void measureTimes(int rounds, Evaluation& evaluation, const std::function<void()>& advanced);

  const Plan& plan_;
  const Sources& sources_;
  Pictures truth_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<double> exposures_;
  std::vector<FlipReference> flips_;
  RecentlyUsed<Pictures> pictures_;
  std::map<std::string, std::vector<WindowChoice>> windows_;  // by hash of the pack: a view
};

// Distances of all picture pairs over their views, in units of `truth`'s rms: root of the mean square.
double relativeRmse(const Evaluator::Pictures& a, const Evaluator::Pictures& b,
                    const Evaluator::Pictures& truth);

}  // namespace bakelight::report
