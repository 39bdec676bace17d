// A JSON object of a file that people write, read with errors that point to the place.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "pipeline/problems.h"

namespace bakelight::pipeline {

class JsonObject {
 public:
  // Throws Error(kBadInput) if `value` is not an object. Keeps a reference to `value`.
  JsonObject(const formats::Json& value, std::string file, std::string pointer = "");

  // Reports each key that is not in `allowed`, with the nearest one that is.
  void allowKeys(const std::vector<std::string>& allowed, Problems& problems) const;

  bool has(std::string_view key) const;
  std::vector<std::string> keys() const;
  ErrorPlace placeOf(std::string_view key) const;
  const formats::Json& value(std::string_view key) const;  // the key must be there

  // Each throws Error(kBadInput) at the key if it is missing (where there is no default) or of another type.
  std::string text(std::string_view key) const;
  std::string text(std::string_view key, const std::string& default_value) const;
  bool boolean(std::string_view key, bool default_value) const;
  std::vector<std::string> texts(std::string_view key) const;  // empty if missing
  JsonObject object(std::string_view key) const;               // empty if missing

 private:
  const formats::Json& require(std::string_view key, const char* expected) const;

  const formats::Json* value_;
  std::string file_, pointer_;
};

// "Did you mean ...?" for errors: `name` if something is near, else the whole list.
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);
std::string join(const std::vector<std::string>& words, const std::string& separator);

}  // namespace bakelight::pipeline
