// The container below a pack: a binary glTF file of one JSON chunk and one binary chunk, cut into sections
// (one glTF bufferView each). Every byte of the file is covered by a check, so that a flipped bit anywhere is
// an error:
//   GLB and chunk headers: by their only possible values;  JSON chunk: by a checksum of itself, kept inside
//   it; sections: by a checksum each, kept in the JSON chunk;  padding between and after them: must be zero.
// Private to formats/pack*.cpp and their tests.
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "formats/mapped_file.h"
#include "formats/pack.h"

namespace bakelight::formats {

inline constexpr const char* kTransferExtension = "BAKELIGHT_radiance_transfer";

// glTF's numbers for what a bufferView is used as.
enum class GlbTarget { kNone = 0, kVertices = 34962, kIndices = 34963 };

class GlbWriter {
 public:
  // Keeps a view of `bytes`, which must outlive finish(). Returns the index of the bufferView.
  int addSection(const std::string& name, std::span<const std::byte> bytes, GlbTarget target);

  // `document` is the glTF without buffers, bufferViews and the document's kTransferExtension; these are
  // filled in. Throws Error(kBadInput) naming `file` if the result would pass 4 GiB (before anything large is
  // allocated) or a name is not UTF-8.
  Bytes finish(Json document, const std::string& file) const;

 private:
  struct Section {
    std::string name;
    std::span<const std::byte> bytes;
    GlbTarget target;
  };

  std::uint64_t binarySize() const;
  std::vector<std::uint64_t> offsets() const;

  std::vector<Section> sections_;
};

// A GLB file that has been checked from end to end. Look-ups are by JSON pointer, and name it when they fail.
class GlbReader {
 public:
  // Throws Error(kBadInput); see decodePack. `bytes` must outlive the reader.
  GlbReader(std::span<const std::byte> bytes, std::string file);
  // Of a whole file, whose memory is given back after each section's check.
  GlbReader(std::shared_ptr<const MappedFile> mapping, std::string file);

  bool has(const std::string& pointer) const;
  const Json& at(const std::string& pointer) const;
  std::uint64_t unsignedAt(const std::string& pointer) const;
  std::string textAt(const std::string& pointer) const;
  float floatAt(const std::string& pointer) const;

  const std::string& file() const { return file_; }
  int version() const { return version_; }

  // Sections in the order of the bufferViews.
  const std::vector<PackSection>& sections() const { return sections_; }
  // The bytes of the bufferView whose index stands at `pointer`.
  std::span<const std::byte> sectionAt(const std::string& pointer) const;
  // Part of the file, to outlive the reader: the mapping itself, or else a copy.
  SharedBytes shared(std::span<const std::byte> part) const;

  // `what` is wrong with the section whose index stands at `pointer` (which sectionAt must have accepted).
  Error sectionError(const std::string& pointer, const std::string& what, const std::string& expected) const;
  // `what` is wrong with the value at `pointer`.
  Error error(const std::string& pointer, const std::string& what, const std::string& expected = "",
              const std::string& remedy = "") const;

 private:
  void readAll();
  void readChunks();
  void readVersion();
  void checkJsonChunk(std::span<const std::byte> chunk) const;
  void readSections();
  void checkPadding() const;

  std::shared_ptr<const MappedFile> mapping_;  // null: of bytes
  std::span<const std::byte> bytes_, binary_;
  std::string file_;
  int version_ = 0;
  Json json_;
  std::vector<PackSection> sections_;
};

}  // namespace bakelight::formats
