// Pictures in a folder or a zip, by name. Private to formats/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "formats/file.h"

namespace bakelight::formats {

class PictureFiles {
 public:
  virtual ~PictureFiles() = default;
  // Of all files below, with "/" between folders, sorted; hidden ones are left out.
  virtual std::vector<std::string> names() const = 0;
  virtual std::uint64_t bytes() const = 0;  // of all of them, as stored
  // A file on the disk with the content of the one of this name; ends with it in a temporary place if it is
  // not there already. From one thread at a time.
  class Local {
   public:
    Local(std::filesystem::path path, bool is_temporary)
        : path_(std::move(path)), is_temporary_(is_temporary) {}
    Local(const Local&) = delete;
    Local& operator=(const Local&) = delete;
    ~Local() {
      std::error_code ignored;
      if (is_temporary_) std::filesystem::remove(path_, ignored);
    }
    const std::filesystem::path& path() const { return path_; }

   private:
    std::filesystem::path path_;
    bool is_temporary_;
  };
  virtual std::unique_ptr<Local> local(const std::string& name) const = 0;
  virtual Bytes read(const std::string& name) const = 0;
  // For messages.
  virtual std::string placeOf(const std::string& name) const = 0;
};

// Throws Error(kBadInput) if it is neither a folder nor a zip that can be opened.
std::unique_ptr<PictureFiles> openPictureFiles(const std::filesystem::path& path);

}  // namespace bakelight::formats
