#include "formats/glb.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/error.h"
#include "formats/hash.h"

namespace bakelight::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are copied into the file as they are in memory");

constexpr std::uint32_t kMagic = 0x46546C67;  // "glTF"
constexpr std::uint32_t kGlbVersion = 2;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN\0"
constexpr std::uint64_t kHeaderSize = 12, kChunkHeaderSize = 8;
constexpr std::uint64_t kChunkAlignment = 4;     // of glTF
constexpr std::uint64_t kSectionAlignment = 16;  // ours: a mapped file can be read with any SIMD width in use
constexpr const char* kDamagedRemedy = "copy or make the pack again, it was damaged or cut short";

// The checksum of the JSON chunk is taken while its own digits are zeros.
constexpr std::string_view kChecksumKey = "\"jsonChecksum\":\"";
constexpr std::string_view kZeroChecksum = "0000000000000000";

std::uint64_t alignedTo(std::uint64_t size, std::uint64_t alignment) {
  return (size + alignment - 1) / alignment * alignment;
}

std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text));
}

// Where the digits of the chunk's own checksum stand. Inside a JSON string the key's quotes would be escaped,
// so the first match is the key.
std::size_t checksumPosition(std::string_view json) {
  const std::size_t key = json.find(kChecksumKey);
  if (key == std::string_view::npos || json.size() - key < kChecksumKey.size() + kZeroChecksum.size()) {
    return std::string_view::npos;
  }
  return key + kChecksumKey.size();
}

std::string dumpJson(const Json& document, const std::string& file) {
  try {
    return document.dump();
  } catch (const Json::exception&) {
    throw badInput({file, "", ""}, "the name of the asset is not UTF-8 text", "UTF-8");
  }
}

void put(Bytes& bytes, std::uint64_t offset, std::span<const std::byte> part) {
  if (!part.empty()) std::memcpy(bytes.data() + offset, part.data(), part.size());
}

void putWords(Bytes& bytes, std::uint64_t offset, std::initializer_list<std::uint64_t> words) {
  for (const std::uint64_t wide : words) {
    const auto word = static_cast<std::uint32_t>(wide);
    put(bytes, offset, std::as_bytes(std::span(&word, 1)));
    offset += sizeof word;
  }
}

std::uint32_t wordAt(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

// For messages; a list or an object may be nested deeper than the stack.
std::string shown(const Json& value) {
  return value.is_primitive() ? value.dump() : value.type_name();
}

std::string extensionPointer(const std::string& key) {
  return std::string("/extensions/") + kTransferExtension + "/" + key;
}

}  // namespace

// ---- writing

int GlbWriter::addSection(const std::string& name, std::span<const std::byte> bytes, GlbTarget target) {
  sections_.push_back({name, bytes, target});
  return static_cast<int>(sections_.size()) - 1;
}

std::vector<std::uint64_t> GlbWriter::offsets() const {
  std::vector<std::uint64_t> result;
  std::uint64_t end = 0;
  for (const Section& section : sections_) {
    result.push_back(alignedTo(end, kSectionAlignment));
    end = result.back() + section.bytes.size();
  }
  return result;
}

std::uint64_t GlbWriter::binarySize() const {
  return sections_.empty() ? 0 : offsets().back() + sections_.back().bytes.size();
}

Bytes GlbWriter::finish(Json document, const std::string& file) const {
  // The JSON chunk takes some kilobytes; its size is not known yet, and a megabyte is more than it ever
  // needs.
  constexpr std::uint64_t kJsonAllowance = 1 << 20;
  if (binarySize() + kJsonAllowance > std::numeric_limits<std::uint32_t>::max()) {
    throw badInput({file, "", ""}, "the pack would have " + std::to_string(binarySize()) + " bytes",
                   "less than 4 GiB, the limit of binary glTF", "lower the number of vertices or the order");
  }
  const auto offset = offsets();
  Json checksums = Json::array();
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const Section& section = sections_[i];
    Json view = {{"buffer", 0},
                 {"byteOffset", offset[i]},
                 {"byteLength", section.bytes.size()},
                 {"name", section.name}};
    if (section.target != GlbTarget::kNone) view["target"] = static_cast<int>(section.target);
    document["bufferViews"].push_back(std::move(view));
    checksums.push_back({{"bufferView", i}, {"checksum", checksumHex(section.bytes)}});
  }
  document["buffers"] = {{{"byteLength", binarySize()}}};
  document["extensions"][kTransferExtension] = {
      {"version", kPackVersion}, {"jsonChecksum", kZeroChecksum}, {"sections", std::move(checksums)}};

  std::string json = dumpJson(document, file);
  // So that sections are aligned in the file as well, not only in the chunk.
  const std::uint64_t before = kHeaderSize + 2 * kChunkHeaderSize;
  json.resize(alignedTo(before + json.size(), kSectionAlignment) - before, ' ');
  json.replace(checksumPosition(json), kZeroChecksum.size(), checksumHex(bytesOf(json)));

  const std::uint64_t binary_size = alignedTo(binarySize(), kChunkAlignment);
  const std::uint64_t binary = before + json.size();  // where sections begin
  const std::uint64_t total = binary + binary_size;
  Bytes bytes(total);  // zeros, and so is the padding
  putWords(bytes, 0, {kMagic, kGlbVersion, total, json.size(), kJsonChunk});
  put(bytes, kHeaderSize + kChunkHeaderSize, bytesOf(json));
  putWords(bytes, binary - kChunkHeaderSize, {binary_size, kBinaryChunk});
  for (std::size_t i = 0; i < sections_.size(); ++i) put(bytes, binary + offset[i], sections_[i].bytes);
  return bytes;
}

// ---- reading

GlbReader::GlbReader(std::span<const std::byte> bytes, std::string file)
    : bytes_(bytes), file_(std::move(file)) {
  readAll();
}

GlbReader::GlbReader(std::shared_ptr<const MappedFile> mapping, std::string file)
    : mapping_(std::move(mapping)), bytes_(mapping_->bytes()), file_(std::move(file)) {
  readAll();
}

void GlbReader::readAll() {
  readChunks();
  readSections();
  checkPadding();
}

Error GlbReader::error(const std::string& pointer, const std::string& what, const std::string& expected,
                       const std::string& remedy) const {
  return badInput({file_, "", pointer}, what, expected, remedy);
}

Error GlbReader::sectionError(const std::string& pointer, const std::string& what,
                              const std::string& expected) const {
  return badInput({file_, "section " + sections_[unsignedAt(pointer)].name, pointer}, what, expected);
}

void GlbReader::readChunks() {
  const auto damaged = [this](const std::string& element, const std::string& what,
                              const std::string& expected) {
    return badInput({file_, element, ""}, what, expected, kDamagedRemedy);
  };
  if (bytes_.size() < kHeaderSize + kChunkHeaderSize || wordAt(bytes_, 0) != kMagic) {
    throw badInput({file_, "", ""}, "this is not a pack", "a binary glTF file (.glb)",
                   "make one with the pack tool");
  }
  if (wordAt(bytes_, 4) != kGlbVersion) {
    throw damaged("GLB header", "the container's version is " + std::to_string(wordAt(bytes_, 4)), "2");
  }
  if (wordAt(bytes_, 8) != bytes_.size()) {
    throw damaged("GLB header",
                  "it says " + std::to_string(wordAt(bytes_, 8)) + " bytes, but the file has " +
                      std::to_string(bytes_.size()),
                  "the same number");
  }
  auto rest = bytes_.subspan(kHeaderSize);
  const auto takeChunk = [&](std::uint32_t type, const char* name) {
    if (rest.size() < kChunkHeaderSize || wordAt(rest, 4) != type) {
      throw damaged(name, "there is no such chunk where it should be", "a JSON chunk, then a binary chunk");
    }
    const std::uint64_t size = wordAt(rest, 0);
    if (size > rest.size() - kChunkHeaderSize || size % kChunkAlignment != 0) {
      throw damaged(name, "its size is " + std::to_string(size), "a multiple of 4 that the file can hold");
    }
    const auto chunk = rest.subspan(kChunkHeaderSize, size);
    rest = rest.subspan(kChunkHeaderSize + size);
    return chunk;
  };
  const auto json_chunk = takeChunk(kJsonChunk, "JSON chunk");
  json_ = parseJson({reinterpret_cast<const char*>(json_chunk.data()), json_chunk.size()}, file_);
  // First of all, as only a known version says how to check the rest.
  readVersion();
  checkJsonChunk(json_chunk);
  binary_ = takeChunk(kBinaryChunk, "binary chunk");
  if (!rest.empty())
    throw damaged("", std::to_string(rest.size()) + " bytes follow the binary chunk", "nothing");
}

void GlbReader::readVersion() {
  if (!has(std::string("/extensions/") + kTransferExtension)) {
    throw error("", std::string("it has no ") + kTransferExtension + ": an ordinary glTF model, not a pack",
                "a pack of Bakelight", "make one with the pack tool");
  }
  const std::uint64_t version = unsignedAt(extensionPointer("version"));
  if (version > kPackVersion) {
    throw error(extensionPointer("version"), "the pack has version " + std::to_string(version),
                "at most " + std::to_string(kPackVersion), "read it with a newer Bakelight");
  }
  if (version == 0) throw error(extensionPointer("version"), "there is no version 0", "1 or more");
  version_ = static_cast<int>(version);
}

void GlbReader::checkJsonChunk(std::span<const std::byte> chunk) const {
  const std::string stored = textAt(extensionPointer("jsonChecksum"));
  std::string json(reinterpret_cast<const char*>(chunk.data()), chunk.size());
  const std::size_t position = checksumPosition(json);
  bool matches = position != std::string::npos;
  if (matches) {
    matches = json.compare(position, kZeroChecksum.size(), stored) == 0;
    json.replace(position, kZeroChecksum.size(), kZeroChecksum);
  }
  if (!matches || checksumHex(bytesOf(json)) != stored) {
    throw badInput({file_, "JSON chunk", ""}, "its checksum is wrong", stored, kDamagedRemedy);
  }
}

void GlbReader::readSections() {
  const std::size_t count = at("/bufferViews").size();
  if (at(extensionPointer("sections")).size() != count) {
    throw error(extensionPointer("sections"), "there is not one for each bufferView", std::to_string(count));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::string view = "/bufferViews/" + std::to_string(i);
    const std::string entry = extensionPointer("sections/" + std::to_string(i));
    if (unsignedAt(view + "/buffer") != 0) throw error(view + "/buffer", "there is one buffer", "0");
    if (unsignedAt(entry + "/bufferView") != i) throw error(entry, "it is out of order", std::to_string(i));
    const std::uint64_t offset = unsignedAt(view + "/byteOffset"), size = unsignedAt(view + "/byteLength");
    if (offset > binary_.size() || size > binary_.size() - offset || offset % kSectionAlignment != 0) {
      throw error(view, "its bytes lie outside the binary chunk",
                  "an offset that is a multiple of 16, inside the chunk");
    }
    const auto bytes = binary_.subspan(offset, size);
    const std::string checksum = checksumHex(bytes, [this](std::span<const std::byte> read) {
      if (mapping_) mapping_->release(read);
    });
    PackSection section{textAt(view + "/name"), static_cast<std::uint64_t>(bytes.data() - bytes_.data()),
                        size, checksum};
    if (section.checksum != textAt(entry + "/checksum")) {
      throw badInput({file_, "section " + section.name, view}, "its checksum is wrong",
                     textAt(entry + "/checksum"), kDamagedRemedy);
    }
    sections_.push_back(std::move(section));
  }
}

void GlbReader::checkPadding() const {
  auto sorted = sections_;
  std::sort(sorted.begin(), sorted.end(),
            [](const PackSection& a, const PackSection& b) { return a.offset_bytes < b.offset_bytes; });
  std::uint64_t end = static_cast<std::uint64_t>(binary_.data() - bytes_.data());
  const auto checkZero = [&](std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t i = from; i < to; ++i) {
      if (bytes_[i] == std::byte{0}) continue;
      throw badInput({file_, "byte " + std::to_string(i), ""}, "the padding between sections is not zero",
                     "zeros", kDamagedRemedy);
    }
  };
  for (const PackSection& section : sorted) {
    if (section.offset_bytes < end) {
      throw badInput({file_, "section " + section.name, ""}, "it overlaps another section",
                     "sections of their own");
    }
    checkZero(end, section.offset_bytes);
    end = section.offset_bytes + section.size_bytes;
  }
  checkZero(end, bytes_.size());
}

bool GlbReader::has(const std::string& pointer) const {
  try {
    return json_.contains(Json::json_pointer(pointer));
  } catch (const Json::exception&) {  // an index that is too large for any list
    return false;
  }
}

const Json& GlbReader::at(const std::string& pointer) const {
  if (!has(pointer)) throw error(pointer, "it is missing", "a value, see docs/FORMATS.md");
  return json_.at(Json::json_pointer(pointer));
}

std::uint64_t GlbReader::unsignedAt(const std::string& pointer) const {
  const Json& value = at(pointer);
  if (!value.is_number_unsigned()) throw error(pointer, shown(value) + " is not valid", "an integer >= 0");
  return value.get<std::uint64_t>();
}

std::string GlbReader::textAt(const std::string& pointer) const {
  const Json& value = at(pointer);
  if (!value.is_string()) throw error(pointer, shown(value) + " is not valid", "text");
  return value.get<std::string>();
}

float GlbReader::floatAt(const std::string& pointer) const {
  const Json& value = at(pointer);
  if (!value.is_number() || !std::isfinite(value.get<float>())) {
    throw error(pointer, shown(value) + " is not valid", "a finite number");
  }
  return value.get<float>();
}

std::span<const std::byte> GlbReader::sectionAt(const std::string& pointer) const {
  const std::uint64_t index = unsignedAt(pointer);
  if (index >= sections_.size()) {
    throw error(pointer, "there is no bufferView " + std::to_string(index),
                "less than " + std::to_string(sections_.size()));
  }
  return bytes_.subspan(sections_[index].offset_bytes, sections_[index].size_bytes);
}

SharedBytes GlbReader::shared(std::span<const std::byte> part) const {
  if (mapping_) return {part, mapping_};
  return Bytes(part.begin(), part.end());
}

}  // namespace bakelight::formats
