#include "formats/named_file.h"

#include <algorithm>
#include <system_error>

#include "formats/file.h"
#include "formats/text_scan.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

class FilesOnDisk : public FileLookup {
 public:
  bool isFile(const fs::path& path) const override {
    std::error_code failed;
    return fs::is_regular_file(path, failed);
  }
  std::vector<std::string> list(const fs::path& folder) const override {
    std::error_code failed;
    std::vector<std::string> names;
    for (fs::directory_iterator entry(folder.empty() ? "." : folder, failed), end; !failed && entry != end;
         entry.increment(failed))
      names.push_back(entry->path().filename().string());
    return names;
  }
  std::string read(const fs::path& path) const override { return readTextFile(path); }
};

fs::path plainName(std::string_view name) {
  name = trimmed(name);
  if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  std::string text(name);
  std::replace(text.begin(), text.end(), '\\', '/');
  return text;
}

// Each part of `name` under `folder` by its exact name or else by one that differs in case; of several the
// first in order. Nothing where a part is missing.
std::optional<fs::path> withAnyCase(const FileLookup& files, fs::path folder, const fs::path& name) {
  for (const fs::path& part : name) {
    if (part == "." || part == "..") {
      folder /= part;
      continue;
    }
    std::vector<std::string> names = files.list(folder);
    std::sort(names.begin(), names.end());
    auto found = std::find(names.begin(), names.end(), part.string());
    if (found == names.end())
      found = std::find_if(names.begin(), names.end(), [&](const std::string& candidate) {
        return equalIgnoringCase(candidate, part.string());
      });
    if (found == names.end()) return std::nullopt;
    folder /= *found;
  }
  return files.isFile(folder) ? std::optional(folder) : std::nullopt;
}

}  // namespace

const FileLookup& filesOnDisk() {
  static const FilesOnDisk files;
  return files;
}

fs::path plainPathOf(const fs::path& folder, std::string_view name) {
  return folder / plainName(name);
}

std::optional<NamedFile> findNamedFile(const FileLookup& files, const fs::path& folder,
                                       std::string_view name) {
  const fs::path plain = plainName(name);
  if (plain.empty()) return std::nullopt;
  if (files.isFile(folder / plain)) return NamedFile{folder / plain, true};
  if (plain.is_relative())
    if (const auto found = withAnyCase(files, folder, plain)) return NamedFile{*found, false};
  if (plain.has_filename() && plain != plain.filename())
    if (const auto found = withAnyCase(files, folder, plain.filename())) return NamedFile{*found, false};
  return std::nullopt;
}

}  // namespace bakelight::formats
