#include "formats/picture_files.h"

#include <unistd.h>
#include <zip.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "formats/error.h"

namespace bakelight::formats {
namespace fs = std::filesystem;
namespace {

bool isHidden(const std::string& name) {
  const std::size_t base = name.find_last_of('/') + 1;
  return base < name.size() && name[base] == '.';
}

class FolderFiles : public PictureFiles {
 public:
  explicit FolderFiles(fs::path folder) : folder_(std::move(folder)) {
    std::error_code failed;
    for (fs::recursive_directory_iterator it(folder_, failed), end; !failed && it != end;
         it.increment(failed)) {
      std::error_code unknown;
      if (!it->is_regular_file(unknown)) continue;
      const std::string name = it->path().lexically_relative(folder_).generic_string();
      if (isHidden(name)) continue;
      names_.push_back(name);
      const std::uint64_t size = it->file_size(unknown);
      if (!unknown) bytes_ += size;
    }
    if (failed)
      throw badInput({folder_.string(), "", ""}, "it cannot be listed: " + failed.message(), "a folder");
    std::ranges::sort(names_);
  }
  std::vector<std::string> names() const override { return names_; }
  std::uint64_t bytes() const override { return bytes_; }
  std::unique_ptr<Local> local(const std::string& name) const override {
    return std::make_unique<Local>(folder_ / name, false);
  }
  Bytes read(const std::string& name) const override { return readFile(folder_ / name); }
  std::string placeOf(const std::string& name) const override { return (folder_ / name).string(); }

 private:
  fs::path folder_;
  std::vector<std::string> names_;
  std::uint64_t bytes_ = 0;
};

class ZipFiles : public PictureFiles {
 public:
  explicit ZipFiles(fs::path path) : path_(std::move(path)) {
    int code = 0;
    zip_.reset(::zip_open(path_.c_str(), ZIP_RDONLY | ZIP_CHECKCONS, &code));
    if (!zip_) {
      zip_error_t error;
      ::zip_error_init_with_code(&error, code);
      const std::string reason = ::zip_error_strerror(&error);
      ::zip_error_fini(&error);
      throw badInput({path_.string(), "", ""}, "the zip cannot be opened: " + reason, "a zip of pictures",
                     "check that the download is whole");
    }
    const zip_int64_t count = ::zip_get_num_entries(zip_.get(), 0);
    for (zip_int64_t i = 0; i < count; ++i) {
      const char* name = ::zip_get_name(zip_.get(), static_cast<zip_uint64_t>(i), ZIP_FL_ENC_GUESS);
      if (name == nullptr || *name == '\0' || std::string_view(name).ends_with('/') || isHidden(name))
        continue;
      indices_.emplace(name, static_cast<zip_uint64_t>(i));
    }
  }
  std::vector<std::string> names() const override {
    std::vector<std::string> names;
    for (const auto& [name, index] : indices_) names.push_back(name);
    return names;
  }
  std::uint64_t bytes() const override { return fs::file_size(path_); }
  std::unique_ptr<Local> local(const std::string& name) const override {
    static std::atomic<unsigned> counter{0};
    const fs::path path = fs::temp_directory_path() / ("bakelight-" + std::to_string(::getpid()) + "-" +
                                                       std::to_string(counter++) + lowerEnding(name));
    auto local = std::make_unique<Local>(path, true);
    writeFileAtomically(path, read(name));
    return local;
  }
  Bytes read(const std::string& name) const override {
    const std::unique_ptr<zip_file_t, decltype(&::zip_fclose)> entry(
        ::zip_fopen_index(zip_.get(), indices_.at(name), 0), &::zip_fclose);
    if (!entry) throw unreadable(name, ::zip_strerror(zip_.get()));
    // What an entry says of its size is not believed.
    constexpr std::size_t kStep = 1 << 20, kMost = std::size_t{1} << 30;
    Bytes bytes;
    while (true) {
      const std::size_t filled = bytes.size();
      if (filled > kMost) throw unreadable(name, "it has more than 1 GiB");
      bytes.resize(filled + kStep);
      const zip_int64_t got = ::zip_fread(entry.get(), bytes.data() + filled, kStep);
      if (got < 0) throw unreadable(name, ::zip_file_strerror(entry.get()));
      bytes.resize(filled + static_cast<std::size_t>(got));
      if (got == 0) return bytes;
    }
  }
  std::string placeOf(const std::string& name) const override { return path_.string() + "/" + name; }

 private:
  Error unreadable(const std::string& name, const std::string& reason) const {
    return badInput({placeOf(name), "", ""}, "the zip's entry cannot be read: " + reason, "a picture",
                    "check that the download is whole");
  }

  fs::path path_;
  std::unique_ptr<zip_t, decltype(&::zip_discard)> zip_{nullptr, &::zip_discard};
  std::map<std::string, zip_uint64_t> indices_;
};

}  // namespace

std::unique_ptr<PictureFiles> openPictureFiles(const fs::path& path) {
  if (fs::is_directory(path)) return std::make_unique<FolderFiles>(path);
  if (!fs::is_regular_file(path))
    throw badInput({path.string(), "", ""}, "there is no such folder or zip", "one");
  return std::make_unique<ZipFiles>(path);
}

}  // namespace bakelight::formats
