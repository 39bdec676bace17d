#include "formats/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "formats/error.h"
#include "formats/file.h"

namespace bakelight::formats {
namespace {

// "line 3, column 14" of the byte at `offset` (the first byte of a file is line 1, column 1).
std::string linePosition(std::string_view text, std::size_t offset) {
  const std::string_view before = text.substr(0, std::min(offset, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - line_start + 1);
}

// nlohmann-json keeps the last of two equal keys without a word; a person who wrote both wants to know.
class DuplicateKeyFinder {
 public:
  bool operator()(int, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key && !keys_.back().insert(parsed.get<std::string>()).second)
      duplicate_ = parsed.get<std::string>();
    return true;
  }
  const std::string& duplicate() const { return duplicate_; }

 private:
  std::vector<std::set<std::string>> keys_;
  std::string duplicate_;
};

}  // namespace

Json parseJson(std::string_view text, const std::string& file) {
  DuplicateKeyFinder finder;
  try {
    Json value = Json::parse(text.begin(), text.end(), std::ref(finder), true, true);
    if (!finder.duplicate().empty())
      throw badInput({file, "", ""}, "the key \"" + finder.duplicate() + "\" stands twice in one object",
                     "each key once", "remove one of the two");
    return value;
  } catch (const Json::out_of_range&) {  // which does not say where
    throw badInput({file, "", ""}, "it has a number that no double can hold", "magnitudes below 1.8e308");
  } catch (const Json::parse_error& error) {
    std::string what = error.what();
    const std::size_t detail = what.find(": ");
    if (detail != std::string::npos) what = what.substr(detail + 2);
    throw badInput({file, linePosition(text, error.byte == 0 ? 0 : error.byte - 1), ""},
                   "is not valid JSON: " + what, "",
                   "look for a missing comma, quote or bracket just before that place");
  }
}

Json readJson(const std::filesystem::path& path) {
  return parseJson(readTextFile(path), path.string());
}

void writeJson(const std::filesystem::path& path, const Json& value) {
  writeFileAtomically(path, value.dump(2) + "\n");
}

std::string childPointer(const std::string& pointer, std::string_view key) {
  std::string escaped;
  for (const char c : key) {
    if (c == '~')
      escaped += "~0";
    else if (c == '/')
      escaped += "~1";
    else
      escaped += c;
  }
  return pointer + "/" + escaped;
}

double shortestDouble(float value) {
  const std::string text = fmt::format("{}", value);
  double result = 0;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}

}  // namespace bakelight::formats
