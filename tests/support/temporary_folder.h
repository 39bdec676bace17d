// A folder that goes with its test.
#pragma once

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>

namespace bakelight::tests {

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::random_device seed;
    path_ = std::filesystem::temp_directory_path() /
            ("bakelight-test-" + std::to_string(seed()) + std::to_string(seed()));
    if (!std::filesystem::create_directory(path_))
      throw std::runtime_error("folder exists: " + path_.string());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  // Names of what lies in it, for "nothing is left behind".
  std::size_t entryCount() const {
    return static_cast<std::size_t>(
        std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
  }

 private:
  std::filesystem::path path_;
};

}  // namespace bakelight::tests
