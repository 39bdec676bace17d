#include "pipeline/problems.h"

#include <algorithm>
#include <utility>

namespace bakelight::pipeline {

ProblemsFound::ProblemsFound(std::vector<Error> errors) : errors_(std::move(errors)) {
  for (const Error& error : errors_) {
    if (!text_.empty()) text_ += '\n';
    text_ += error.paragraph();
  }
}

void Problems::add(Error error) {
  // Two hundred assets may share one broken recipe; it is one problem.
  const bool known = std::any_of(errors_.begin(), errors_.end(),
                                 [&](const Error& other) { return other.paragraph() == error.paragraph(); });
  if (!known) errors_.push_back(std::move(error));
}

void Problems::add(const std::vector<Error>& errors) {
  for (const Error& error : errors) add(error);
}

void Problems::throwIfAny() const {
  if (any()) throw ProblemsFound(errors_);
}

}  // namespace bakelight::pipeline
