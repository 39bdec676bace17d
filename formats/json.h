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

// The double with the shortest decimal text that means the same float: 0.8f is written as 0.8, not as
// 0.800000011920929.
double shortestDouble(float value);

}  // namespace bakelight::formats
