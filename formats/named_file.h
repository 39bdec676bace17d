// Files that a mesh file names: material libraries, textures, buffers. Private to the importers.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bakelight::formats {

// Where they are looked for: the disk, or what the driver sees of it.
class FileLookup {
 public:
  virtual ~FileLookup() = default;
  virtual bool isFile(const std::filesystem::path& path) const = 0;
  virtual std::vector<std::string> list(const std::filesystem::path& folder) const = 0;  // names, any order
  virtual std::string read(const std::filesystem::path& path) const = 0;  // throws Error(kBadInput)
};

const FileLookup& filesOnDisk();

struct NamedFile {
  std::filesystem::path path;
  bool exact = true;  // by the very name; otherwise by one of the makeshifts below
};

// The file that `name`, as it stands in a file in `folder`, means; nothing if there is none. Relative to
// `folder`; blanks and quotes around it are no part of it; backslashes separate folders. Where no file of
// that very name is there: one whose name differs in the case of letters only; then one in `folder` itself
// with the last part of the name, as names from another machine end.
std::optional<NamedFile> findNamedFile(const FileLookup& files, const std::filesystem::path& folder,
                                       std::string_view name);

// What the name says, whether the file is there or not.
std::filesystem::path plainPathOf(const std::filesystem::path& folder, std::string_view name);

}  // namespace bakelight::formats
