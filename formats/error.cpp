#include "formats/error.h"

#include <utility>

namespace bakelight {
namespace {

std::string paragraphOf(const ErrorPlace& place, const std::string& problem, const std::string& expected,
                        const std::string& remedy) {
  std::string text = place.file;
  if (!place.element.empty()) text += (text.empty() ? "" : ", ") + place.element;
  if (!place.pointer.empty()) text += (text.empty() ? "at " : ", at ") + place.pointer;
  if (!text.empty()) text += ": ";
  text += problem + ".";
  if (!expected.empty()) text += " Expected: " + expected + ".";
  if (!remedy.empty()) text += " Try: " + remedy + ".";
  return text;
}

}  // namespace

Error::Error(ExitStatus status, ErrorPlace place, std::string what, std::string expected, std::string remedy)
    : std::runtime_error(paragraphOf(place, what, expected, remedy)),
      status_(status),
      place_(std::move(place)),
      problem_(std::move(what)),
      expected_(std::move(expected)),
      remedy_(std::move(remedy)) {}

Error badInput(ErrorPlace place, std::string what, std::string expected, std::string remedy) {
  return Error(ExitStatus::kBadInput, std::move(place), std::move(what), std::move(expected),
               std::move(remedy));
}

Error cannotWrite(const std::string& file, std::string what) {
  return Error(ExitStatus::kCannotWrite, {.file = file, .element = "", .pointer = ""}, std::move(what), "",
               "free some space or check the permissions of the folder; nothing was changed");
}

}  // namespace bakelight
