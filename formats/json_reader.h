// A value of a JSON file together with where it stands, so that whatever is wrong with it is said with file and
// JSON pointer. All JSON that people or other programs write is read through this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::formats {

struct ParameterDescription;

// Inclusive; of itself all finite numbers.
struct NumberRange {
  double minimum = std::numeric_limits<double>::lowest(), maximum = std::numeric_limits<double>::max();
};

// Every error is Error(kBadInput) at the value's place. Types, ranges and choices are judged by the rules that
// tools' parameters have (formats/tool_description.h).
class JsonReader {
 public:
  using Range = NumberRange;

  // `value` must outlive the reader and all that come from it. `pointer` "" is the whole file. `remedy` is
  // said with errors that have none of their own: what helps if the file is not written by hand.
  JsonReader(const Json& value, std::string file, std::string pointer = "", std::string remedy = "");

  const Json& value() const { return *value_; }
  const std::string& file() const { return source_->file; }
  const std::string& pointer() const { return pointer_; }
  ErrorPlace place() const { return {file(), "", pointer_}; }
  Error error(const std::string& what, const std::string& expected = "", const std::string& remedy = "",
              const std::string& element = "") const;

  // The value itself; each throws if it is something else.
  const std::string& text() const;
  bool boolean() const;
  double number(Range range = {}) const;  // finite
  int integer(int minimum, int maximum) const;
  std::uint64_t whole() const;  // from 0 to 2⁵³; 12.0 is one, too
  Float3 float3(Range range = {}) const;
  std::vector<double> numbers(std::size_t count) const;
  std::vector<std::string> texts() const;
  template <class Value, std::size_t N>
  const Value& choice(const Word<Value> (&words)[N]) const {
    return words[choiceAmong(textsOf(words))].value;
  }

  // Of a list; each throws if it is none.
  std::size_t size() const;
  JsonReader at(std::size_t index) const;  // index < size()
  std::vector<JsonReader> items() const;

  // Of an object; each throws if it is none.
  std::vector<std::string> keys() const;
  bool has(std::string_view key) const;
  ErrorPlace placeOf(std::string_view key) const;
  std::optional<JsonReader> find(std::string_view key) const;
  JsonReader at(std::string_view key, const std::string& expected = "") const;  // throws if it is missing
  const Json& value(std::string_view key) const { return at(key).value(); }

  // Of its members; each throws if the member is missing, unless there is a default.
  const std::string& text(std::string_view key) const { return at(key, "a text").text(); }
  std::string text(std::string_view key, const std::string& otherwise) const;
  bool boolean(std::string_view key, bool otherwise) const;
  double number(std::string_view key, Range range = {}) const { return at(key, "a number").number(range); }
  std::uint64_t whole(std::string_view key, std::uint64_t otherwise) const;
  template <class Value, std::size_t N>
  const Value& choice(std::string_view key, const Word<Value> (&words)[N]) const {
    return at(key, oneOf(textsOf(words))).choice(words);
  }
  // An existing file; its name is relative to the folder of this one.
  std::filesystem::path existingFile(std::string_view key, const std::string& expected,
                                     const std::string& remedy) const;
  // Empty if the member is missing.
  std::vector<std::string> texts(std::string_view key) const;
  std::vector<JsonReader> items(std::string_view key) const;
  JsonReader object(std::string_view key) const;

  // A member that is missing leaves `value` alone.
  void read(std::string_view key, bool& value) const;
  void read(std::string_view key, int& value, Range range) const;
  void read(std::string_view key, double& value, Range range) const;
  void read(std::string_view key, Float3& value, Range range) const;
  void read(std::string_view key, std::string& value) const;
  template <class Value, std::size_t N>
  void read(std::string_view key, Value& value, const Word<Value> (&words)[N]) const {
    if (const auto member = find(key)) value = member->choice(words);
  }

  // An error for each key of the object that is not in `allowed`; with the nearest one that is.
  std::vector<Error> unknownKeys(const std::vector<std::string>& allowed) const;
  // Throws for the first key that is not in `allowed`.
  void allowKeys(const std::vector<std::string>& allowed) const;
  // Allows those that have been asked for, of this very reader: to be called after the last.
  void refuseOthers() const { allowKeys(asked_); }

 private:
  struct Source {
    std::string file, remedy;
  };

  JsonReader(const Json& value, std::shared_ptr<const Source> source, std::string pointer);
  Json checked(const ParameterDescription& rule) const;
  const Json& asObject() const;
  const Json& asList() const;
  const Json* member(std::string_view key) const;
  std::size_t choiceAmong(const std::vector<std::string>& texts) const;
  static std::string oneOf(const std::vector<std::string>& texts);

  const Json* value_;
  std::shared_ptr<const Source> source_;
  std::string pointer_;
  mutable std::vector<std::string> asked_;
};

}  // namespace bakelight::formats
