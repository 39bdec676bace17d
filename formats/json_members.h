// The members of one JSON object of a file that people write, each asked for by name and judged by the rule
// that tools' parameters have; what nobody asked for is unknown.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/triangle_mesh.h"

namespace bakelight::formats {

// Every error is Error(kBadInput) that names file and JSON pointer.
class JsonMembers {
 public:
  struct Range {
    double minimum, maximum;  // inclusive
  };

  // Throws if `object` is none. Keeps a reference to it.
  JsonMembers(const Json& object, std::string file, std::string pointer);

  ErrorPlace placeOf(const std::string& name) const;
  const std::string& file() const { return file_; }
  std::vector<std::string> names() const;

  // Null if it is not there.
  const Json* find(const std::string& name);
  const Json& require(const std::string& name, const std::string& expected);

  // A member that is not there leaves its value alone.
  void read(const std::string& name, double& value, Range range);
  void read(const std::string& name, bool& value);
  void read(const std::string& name, Float3& value, Range range);
  void read(const std::string& name, std::string& value);
  // The place of the chosen word among `choices`; it has to be there.
  std::size_t readChoice(const std::string& name, const std::vector<std::string>& choices);
  // An existing file; its name is relative to the folder of this one. It has to be there.
  std::filesystem::path readFile(const std::string& name, const std::string& expected,
                                 const std::string& remedy);

  static Float3 triple(const Json& json, const std::string& name, Range range, const ErrorPlace& place);
  static double real(const Json& json, const std::string& name, Range range, const ErrorPlace& place);

  // To be called after everything has been asked for: an unknown key is refused with the nearest one.
  void refuseOthers() const;

 private:
  const Json& object_;
  std::string file_, pointer_;
  std::vector<std::string> known_;
};

}  // namespace bakelight::formats
