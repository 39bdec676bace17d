// A folder of tools in which one is broken on purpose.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace bakelight::tests {

// Links to the programs of `bin` in the new folder `folder`, but for transfer: a script that runs it through
// `broken_stage` (tests/e2e/broken_stage.cpp), which spoils what it writes in the way of `kind`. As the
// driver goes by the content of what it runs, each kind has cache entries of its own.
inline void makeBrokenTools(const std::filesystem::path& folder, const std::filesystem::path& bin,
                            const std::filesystem::path& broken_stage, const std::string& kind) {
  namespace fs = std::filesystem;
  fs::create_directories(folder);
  for (const auto& entry : fs::directory_iterator(bin))
    if (entry.is_regular_file() && entry.path().filename() != "transfer")
      fs::create_symlink(entry.path(), folder / entry.path().filename());
  const fs::path script = folder / "transfer";
  std::ofstream(script) << "#!/bin/sh\nexec '" << broken_stage.string() << "' " << kind << " '"
                        << (bin / "transfer").string() << "' \"$@\"\n";
  fs::permissions(script, fs::perms::owner_exec, fs::perm_options::add);
}

}  // namespace bakelight::tests
