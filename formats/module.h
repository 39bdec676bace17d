// Libraries that a program loads when it needs them, so that it starts without what its work at hand does not
// need. Private to formats/, and to the driver, as a tool's results depend on them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace bakelight::formats {

// All of them, for the tools in a folder: ../lib/bakelight/NAME.so.
std::vector<std::filesystem::path> modulesOf(const std::filesystem::path& tools);

// The address that the function `entry` of the module beside this program returns; loads it at the first
// call. Throws Error(kNotAvailable) naming the module if it is not there, cannot be loaded, or is of another
// kind.
const void* moduleEntry(const std::string& name, const std::string& entry);

}  // namespace bakelight::formats
