// JSON files read with errors that name the file and the place. nlohmann-json's own header stays in .cpp
// files.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace bakelight::formats {

using Json = nlohmann::json;  // object keys sorted: one canonical text per value

// Comments (// and /* */) are allowed, a key that stands twice in one object is not.
// Throws Error(kBadInput) with line and column on a syntax error.
Json parseJson(std::string_view text, const std::string& file);
Json readJson(const std::filesystem::path& path);

// Two-space indented, ending in a newline; atomic.
void writeJson(const std::filesystem::path& path, const Json& value);

// `pointer` + "/" + `key`, with the escapes of RFC 6901.
std::string childPointer(const std::string& pointer, std::string_view key);

// The candidate with the smallest edit distance to `name`, or "" if none is near enough to be a likely
// misspelling.
template <class Strings>
std::string nearestName(std::string_view name, const Strings& candidates);
std::size_t editDistance(std::string_view a, std::string_view b);

template <class Strings>
std::string nearestName(std::string_view name, const Strings& candidates) {
  std::string best;
  std::size_t best_distance = name.size() / 3 + 2;
  for (const auto& candidate : candidates) {
    const std::size_t distance = editDistance(name, candidate);
    if (distance < best_distance) best = candidate, best_distance = distance;
  }
  return best;
}

}  // namespace bakelight::formats
