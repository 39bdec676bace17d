// A place in a glTF document: a JSON value that knows its pointer, so that whatever is wrong with it is said
// there. Private to the glTF reader.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"

namespace bakelight::formats {

class GltfValue {
 public:
  // `json` must outlive the value; `file` is for messages.
  GltfValue(const Json& json, std::string pointer, std::shared_ptr<const std::string> file);

  const std::string& pointer() const { return pointer_; }
  Error error(const std::string& what, const std::string& expected = "", const std::string& remedy = "",
              const std::string& element = "") const;

  // Of an object. find returns nothing, and at throws, if the key is absent; both throw if this is none.
  std::optional<GltfValue> find(std::string_view key) const;
  GltfValue at(std::string_view key) const;
  // The object under /extensions/NAME, if there is one.
  std::optional<GltfValue> extension(std::string_view name) const;
  std::vector<std::string> keys() const;

  // Of a list; throw if this is none.
  std::size_t size() const;
  GltfValue at(std::size_t index) const;  // index < size()

  // Throw if this is something else. whole() takes 12 and 12.0, up to 2⁵³.
  std::uint64_t whole() const;
  double number() const;
  bool truth() const;
  const std::string& text() const;
  std::vector<double> numbers(std::size_t count) const;

 private:
  const Json* json_;
  std::string pointer_;
  std::shared_ptr<const std::string> file_;
};

// What stands under `key`, or what is assumed if nothing does.
std::uint64_t wholeOr(const GltfValue& object, std::string_view key, std::uint64_t otherwise);
bool truthOr(const GltfValue& object, std::string_view key, bool otherwise);
std::string textOr(const GltfValue& object, std::string_view key, const std::string& otherwise);

}  // namespace bakelight::formats
