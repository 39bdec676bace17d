// Everything that is wrong, told at once: validation goes on after a first mistake, so that a user mends all
// of them in one round.
#pragma once

#include <exception>
#include <string>
#include <vector>

#include "formats/error.h"

namespace bakelight::pipeline {

// One or more errors. what() has one line an error.
class ProblemsFound : public std::exception {
 public:
  explicit ProblemsFound(std::vector<Error> errors);
  const std::vector<Error>& errors() const { return errors_; }
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::vector<Error> errors_;
  std::string text_;
};

class Problems {
 public:
  void add(Error error);
  void add(const std::vector<Error>& errors);

  // Runs `step`; what it throws is kept instead. Returns whether it went through.
  template <class Step>
  bool attempt(Step&& step) {
    try {
      step();
      return true;
    } catch (const ProblemsFound& found) {
      for (const Error& error : found.errors()) add(error);
    } catch (const Error& error) {
      add(error);
    }
    return false;
  }

  bool any() const { return !errors_.empty(); }
  // Throws ProblemsFound if there are any.
  void throwIfAny() const;

 private:
  std::vector<Error> errors_;
};

}  // namespace bakelight::pipeline
