// A value of a JSON file together with where it stands, so that everything that is wrong with it can be said
// with file and JSON pointer.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"

namespace bakelight::report {

class JsonElement {
 public:
  // `value` must outlive the element. `pointer` "" is the whole file.
  JsonElement(const formats::Json& value, std::string file, std::string pointer = "");

  // All of these throw Error(kBadInput) at the element's place for another type.
  std::string text() const;
  double number() const;       // finite
  double atLeastZero() const;  // finite, ≥ 0
  std::vector<JsonElement> items() const;
  // Each of `required` must be a key of the object; a key that is neither there nor in `optional` is an error
  // that names the nearest valid one.
  void requireKeys(const std::vector<std::string>& required,
                   const std::vector<std::string>& optional = {}) const;
  // Of an object that has the key.
  JsonElement at(const std::string& key) const;
  // Nothing if the object has no such key, or null there.
  std::optional<JsonElement> find(const std::string& key) const;

  Error error(const std::string& what, const std::string& expected) const;
  const formats::Json& value() const { return *value_; }
  const std::string& file() const { return file_; }
  const std::string& pointer() const { return pointer_; }

 private:
  const formats::Json* value_;
  std::string file_, pointer_;
};

}  // namespace bakelight::report
