// The file system as the driver sees it. The graph, the cache and the scheduler touch files only through
// this, so that their tests run in memory and can count what was read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bakelight::pipeline {

struct FileStat {
  bool folder = false;
  std::uint64_t bytes = 0;
  std::int64_t mtime_ns = 0;  // since the epoch
  std::uint64_t inode = 0;

  bool operator==(const FileStat&) const = default;
};

// Reading throws Error(kBadInput), changing throws Error(kCannotWrite), each naming the path.
class Disk {
 public:
  using Path = std::filesystem::path;
  virtual ~Disk() = default;

  // Follows symbolic links; nothing if there is no such file.
  virtual std::optional<FileStat> stat(const Path& path) const = 0;
  virtual std::vector<std::string> list(const Path& folder) const = 0;  // names, sorted
  virtual std::string read(const Path& path) const = 0;
  virtual std::string hash(const Path& path) const = 0;  // formats::contentHash
  virtual std::int64_t now_ns() const = 0;               // on the clock that stamps mtime_ns

  virtual void makeFolders(const Path& folder) = 0;
  virtual void write(const Path& path, std::string_view text) = 0;  // atomic; makes parent folders
  // Atomic; makes parent folders; shares the blocks where the file system can.
  virtual void copy(const Path& from, const Path& to) = 0;
  virtual void rename(const Path& from, const Path& to) = 0;  // files and folders; makes parent folders
  virtual void removeAll(const Path& path) = 0;               // nothing if there is none

  bool isFile(const Path& path) const;
  bool isFolder(const Path& path) const;
};

class RealDisk : public Disk {
 public:
  std::optional<FileStat> stat(const Path& path) const override;
  std::vector<std::string> list(const Path& folder) const override;
  std::string read(const Path& path) const override;
  std::string hash(const Path& path) const override;
  std::int64_t now_ns() const override;
  void makeFolders(const Path& folder) override;
  void write(const Path& path, std::string_view text) override;
  void copy(const Path& from, const Path& to) override;
  void rename(const Path& from, const Path& to) override;
  void removeAll(const Path& path) override;
};

// Held while a driver works in an output folder, so that a second one waits its turn. The lock goes with the
// process: nothing is left over after a crash.
class FolderLock {
 public:
  // Makes the folder if needed; does not take the lock yet. Throws Error(kCannotWrite).
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  bool tryLock();  // whether it is held now

 private:
  int descriptor_ = -1;
};

}  // namespace bakelight::pipeline
