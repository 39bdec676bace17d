// The one exception type of the project. It is thrown anywhere and caught in one place: tools/stage (for a
// tool) and the driver's main (for `bakelight`).
#pragma once

#include <stdexcept>
#include <string>

namespace bakelight {

// What a process says to its caller. The numbers are part of the command-line contract (docs/FORMATS.md).
enum class ExitStatus : int {
  kDone = 0,
  kUsage = 1,         // the command line itself is wrong
  kBadInput = 2,      // a file, or a value in a file, is wrong
  kNotAvailable = 3,  // this machine lacks what is asked for (no GL, no scheduler)
  kCannotWrite = 4,   // an output could not be written (full disk, no permission)
  kInterrupted = 130  // SIGINT or SIGTERM
};

// Where the trouble is. Any part may be empty.
struct ErrorPlace {
  std::string file;     // path as the user gave it
  std::string element;  // "face 12", "channel sh00.R", "tensor transfer"
  std::string pointer;  // JSON pointer (RFC 6901), "/stages/transfer/order"
};

// An error that a user can act on: where, what, what was expected, what to do.
class Error : public std::runtime_error {
 public:
  // `what`, `expected` and `remedy` are sentences without a final full stop; `expected` and `remedy` may be
  // empty.
  Error(ExitStatus status, ErrorPlace place, std::string what, std::string expected = "",
        std::string remedy = "");

  ExitStatus status() const { return status_; }
  const ErrorPlace& place() const { return place_; }
  const std::string& problem() const { return problem_; }
  const std::string& expected() const { return expected_; }
  const std::string& remedy() const { return remedy_; }

  // One paragraph, for example:
  //   asset.json, at /stages/transfer/order: 99 is out of range. Expected: an integer from 1 to 10. Try:
  //   lower it.
  std::string paragraph() const { return what(); }

 private:
  ExitStatus status_;
  ErrorPlace place_;
  std::string problem_, expected_, remedy_;
};

// Shorthands for the two commonest kinds.
Error badInput(ErrorPlace place, std::string what, std::string expected = "", std::string remedy = "");
Error cannotWrite(const std::string& file, std::string what);

}  // namespace bakelight
