// A glTF 2.0 file opened: its JSON, and the bytes that it refers to. Private to the glTF reader.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/file.h"
#include "formats/json_reader.h"

namespace bakelight::formats {

struct GltfView {
  std::span<const std::byte> bytes;
  std::size_t stride = 0;  // 0: elements follow each other
};

class GltfDocument {
 public:
  // Text or binary, told apart by content. Throws Error(kBadInput) if the container is malformed, the version
  // is not 2.x or an extension is required that is not known. `bytes` must outlive the document.
  GltfDocument(const std::filesystem::path& path, std::span<const std::byte> bytes,
               std::vector<std::string>& notes);
  ~GltfDocument();

  const std::string& file() const { return file_; }
  std::filesystem::path folder() const { return folder_; }
  JsonReader root() const;

  // How many things are listed under /SECTION (0 without the section), and one of them.
  std::size_t count(const char* section) const;
  JsonReader item(const char* section, std::size_t index) const;
  // The index that stands at `reference`; throws unless /SECTION has as many.
  std::size_t indexAt(const JsonReader& reference, const char* section) const;
  JsonReader referred(const JsonReader& reference, const char* section) const;

  // Buffers are loaded, and views decompressed (EXT_meshopt_compression), when first asked for.
  GltfView view(const JsonReader& reference);
  // `length` bytes from `offset` on of the buffer whose index stands at `reference`; `place` is blamed if the
  // buffer is shorter.
  std::span<const std::byte> bufferBytes(const JsonReader& reference, std::uint64_t offset,
                                         std::uint64_t length, const JsonReader& place);
  // All bytes of all files of the document so far.
  std::uint64_t loadedBytes() const;

 private:
  void openBinary(std::span<const std::byte> bytes, std::vector<std::string>& notes);
  void openText(std::string_view text);
  void checkVersion() const;
  void checkExtensions() const;
  void loadBuffer(std::size_t index);
  Bytes bytesOfUri(const JsonReader& uri) const;

  struct Buffer {
    Bytes own;
    std::span<const std::byte> bytes;
  };

  std::string file_;
  std::filesystem::path folder_;
  std::unique_ptr<Json> json_;
  std::optional<std::span<const std::byte>> binary_;  // the BIN chunk
  std::vector<std::optional<Buffer>> buffers_;
  std::vector<std::optional<Bytes>> unpacked_views_;
};

// Where the file of `uri` lies, if it exists.
std::optional<std::filesystem::path> fileOfUri(const std::string& uri, const std::filesystem::path& folder);
// The same, or the error at its pointer.
std::filesystem::path existingFile(const JsonReader& uri, const std::filesystem::path& folder);

// The object under /extensions/NAME of an object, if there is one.
std::optional<JsonReader> extensionOf(const JsonReader& object, std::string_view name);

// Whether the view is compressed by EXT_meshopt_compression, and its content if it is.
std::optional<Bytes> meshoptDecoded(const JsonReader& view, GltfDocument& document);

}  // namespace bakelight::formats
