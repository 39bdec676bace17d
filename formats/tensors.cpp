#include "formats/tensors.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "formats/error.h"
#include "formats/json.h"
#include "formats/mapped_file.h"
#include "formats/tensor_writer.h"
#include "formats/words.h"

namespace bakelight::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are copied into the file as they are in memory");

constexpr std::size_t kLengthSize = 8;                 // bytes of the length in front of the header
constexpr std::size_t kHeaderAlignment = 8;            // bytes; so that a mapped file gives aligned arrays
constexpr std::uint64_t kMaxHeaderSize = 100'000'000;  // bytes; the limit of the reference implementation
constexpr const char* kMetadataKey = "__metadata__";

struct TypeRow {
  ElementType type;
  const char* name;
  std::size_t size;
};
constexpr TypeRow kTypes[] = {
    {ElementType::kFloat32, "F32", 4}, {ElementType::kFloat16, "F16", 2}, {ElementType::kFloat64, "F64", 8},
    {ElementType::kUint8, "U8", 1},    {ElementType::kUint16, "U16", 2},  {ElementType::kUint32, "U32", 4},
    {ElementType::kInt32, "I32", 4},   {ElementType::kInt64, "I64", 8},
};

const TypeRow& rowOf(ElementType type) {
  for (const TypeRow& row : kTypes) {
    if (row.type == type) return row;
  }
  throw std::logic_error("no such element type");
}

std::optional<std::uint64_t> product(std::uint64_t a, std::uint64_t b) {
  if (b != 0 && a > std::numeric_limits<std::uint64_t>::max() / b) return std::nullopt;
  return a * b;
}

std::optional<std::uint64_t> byteSize(ElementType type, const std::vector<std::uint64_t>& shape) {
  std::optional<std::uint64_t> size = sizeOf(type);
  for (const std::uint64_t extent : shape) {
    if (size) size = product(*size, extent);
  }
  return size;
}

struct Placement {
  std::string name;
  ElementType type;
  std::vector<std::uint64_t> shape;
  std::uint64_t begin, end;  // bytes, from the end of the header
};

class HeaderReader {
 public:
  HeaderReader(std::string file, std::uint64_t data_size) : file_(std::move(file)), data_size_(data_size) {}

  Placement placement(const std::string& name, const Json& entry) const {
    if (!entry.is_object()) throw error(name, "its entry is not an object", "dtype, shape and data_offsets");
    for (const auto& [key, value] : entry.items()) {
      if (key != "dtype" && key != "shape" && key != "data_offsets") {
        throw error(name, "'" + key + "' is unknown", "dtype, shape and data_offsets");
      }
    }
    Placement placement{name, typeIn(name, entry), unsignedList(name, entry, "shape"), 0, 0};
    const auto offsets = unsignedList(name, entry, "data_offsets");
    if (offsets.size() != 2 || offsets[0] > offsets[1] || offsets[1] > data_size_) {
      throw error(name, "its data_offsets are outside the file",
                  "two offsets, rising, up to " + std::to_string(data_size_),
                  "make the file again, it was cut short");
    }
    placement.begin = offsets[0];
    placement.end = offsets[1];
    const auto size = byteSize(placement.type, placement.shape);
    if (!size || *size != placement.end - placement.begin) {
      throw error(name,
                  "its shape and type do not fit its " + std::to_string(placement.end - placement.begin) +
                      " bytes of data",
                  size ? std::to_string(*size) + " bytes" : "a product that fits 64 bits");
    }
    return placement;
  }

  // Arrays stand one after the other, without a hole, up to the end of the file.
  void checkTiling(std::vector<Placement>& placements) const {
    std::sort(placements.begin(), placements.end(), [](const Placement& a, const Placement& b) {
      return std::tie(a.begin, a.end, a.name) < std::tie(b.begin, b.end, b.name);
    });
    std::uint64_t end = 0;
    for (const Placement& placement : placements) {
      if (placement.begin != end) {
        throw error(
            placement.name,
            placement.begin < end ? "its data overlap another tensor's" : "a hole lies before its data",
            "data from byte " + std::to_string(end) + " on");
      }
      end = placement.end;
    }
    if (end != data_size_) {
      throw error("", std::to_string(data_size_ - end) + " bytes follow the last tensor",
                  "the end of the file");
    }
  }

  std::map<std::string, std::string> metadata(const Json& entry) const {
    std::map<std::string, std::string> result;
    if (!entry.is_object()) throw error(kMetadataKey, "it is not an object", "an object of strings");
    for (const auto& [key, value] : entry.items()) {
      if (!value.is_string())
        throw error(kMetadataKey, "'" + key + "' is not a string", "an object of strings");
      result[key] = value.get<std::string>();
    }
    return result;
  }

 private:
  Error error(const std::string& name, const std::string& what, const std::string& expected,
              const std::string& remedy = "") const {
    return badInput({file_, name.empty() ? "" : "tensor " + name, ""}, what, expected, remedy);
  }

  ElementType typeIn(const std::string& name, const Json& entry) const {
    const auto dtype = entry.find("dtype");
    for (const TypeRow& row : kTypes) {
      if (dtype != entry.end() && *dtype == row.name) return row.type;
    }
    throw error(name, "its dtype is missing or not supported", "F32, F16, F64, U8, U16, U32, I32 or I64");
  }

  std::vector<std::uint64_t> unsignedList(const std::string& name, const Json& entry, const char* key) const {
    const auto list = entry.find(key);
    bool valid = list != entry.end() && list->is_array();
    if (valid)
      valid = std::all_of(list->begin(), list->end(), [](const Json& v) { return v.is_number_unsigned(); });
    if (!valid)
      throw error(name, std::string("its ") + key + " is missing or malformed", "a list of integers >= 0");
    return list->get<std::vector<std::uint64_t>>();
  }

  std::string file_;
  std::uint64_t data_size_;
};

std::string checkedDump(const Json& header) {
  try {
    return header.dump();
  } catch (const Json::exception&) {
    throw badInput({}, "a tensor's name or a metadata value is not UTF-8 text", "UTF-8");
  }
}

}  // namespace

std::size_t sizeOf(ElementType type) {
  return rowOf(type).size;
}
const char* safetensorsName(ElementType type) {
  return rowOf(type).name;
}

std::uint64_t Tensor::elementCount() const {
  std::uint64_t count = 1;
  for (const std::uint64_t extent : shape) count *= extent;
  return count;
}

const Tensor& TensorFile::require(const std::string& name, ElementType type, std::size_t rank,
                                  const std::string& file) const {
  const auto entry = tensors.find(name);
  if (entry == tensors.end()) {
    std::vector<std::string> names;
    for (const auto& [present, tensor] : tensors) names.push_back(present);
    const std::string nearest = nearestName(name, names);
    throw badInput({file, "tensor " + name, ""}, "there is no such tensor", "",
                   nearest.empty() ? "" : "is it called " + nearest + "?");
  }
  const Tensor& tensor = entry->second;
  if (tensor.type != type || tensor.shape.size() != rank) {
    throw badInput({file, "tensor " + name, ""},
                   std::string("it is ") + safetensorsName(tensor.type) + " with " +
                       std::to_string(tensor.shape.size()) + " dimensions",
                   std::string(safetensorsName(type)) + " with " + std::to_string(rank));
  }
  return tensor;
}

const std::string& TensorFile::requireMetadata(const std::string& key, const std::string& file) const {
  const auto entry = metadata.find(key);
  if (entry == metadata.end()) {
    throw badInput({file, std::string("metadata ") + key, ""}, "there is no such key in __metadata__");
  }
  return entry->second;
}

TensorLayout layOutTensors(const std::map<std::string, TensorShape>& tensors,
                           const std::map<std::string, std::string>& metadata) {
  // Wide types first, so that each array is aligned for its type; by name within a width.
  std::vector<std::pair<std::string, const TensorShape*>> order;
  for (const auto& [name, tensor] : tensors) order.emplace_back(name, &tensor);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return sizeOf(a.second->type) > sizeOf(b.second->type);
  });

  Json header = Json::object();
  if (!metadata.empty()) header[kMetadataKey] = metadata;
  TensorLayout layout;
  std::uint64_t offset = 0;
  for (const auto& [name, tensor] : order) {
    if (name == kMetadataKey) throw std::logic_error("a tensor cannot be called __metadata__");
    const auto size = byteSize(tensor->type, tensor->shape);
    if (!size || *size > std::numeric_limits<std::uint64_t>::max() - offset)
      throw std::logic_error("tensor " + name + ": its size overflows");
    header[name] = {{"dtype", safetensorsName(tensor->type)},
                    {"shape", tensor->shape},
                    {"data_offsets", {offset, offset + *size}}};
    layout.places.push_back({name, {offset, offset + *size}});
    offset += *size;
  }
  std::string text = checkedDump(header);
  text.resize((text.size() + kHeaderAlignment - 1) / kHeaderAlignment * kHeaderAlignment, ' ');

  layout.header.resize(kLengthSize + text.size());
  const std::uint64_t length = text.size();
  std::memcpy(layout.header.data(), &length, kLengthSize);
  std::memcpy(layout.header.data() + kLengthSize, text.data(), text.size());
  return layout;
}

namespace {

std::map<std::string, TensorShape> shapesOf(const TensorFile& file) {
  std::map<std::string, TensorShape> shapes;
  for (const auto& [name, tensor] : file.tensors) {
    if (byteSize(tensor.type, tensor.shape) != tensor.data.size())
      throw std::logic_error("tensor " + name + ": shape and data differ");
    shapes[name] = {tensor.type, tensor.shape};
  }
  return shapes;
}

}  // namespace

Bytes encodeSafetensors(const TensorFile& file) {
  TensorLayout layout = layOutTensors(shapesOf(file), file.metadata);
  Bytes bytes = std::move(layout.header);
  bytes.reserve(bytes.size() + (layout.places.empty() ? 0 : layout.places.back().second.end));
  for (const auto& [name, place] : layout.places) {
    const SharedBytes& data = file.tensors.at(name).data;
    bytes.insert(bytes.end(), data.begin(), data.end());
  }
  return bytes;
}

namespace {

// `owner` keeps `bytes`; without one, tensors own copies.
TensorFile decode(std::span<const std::byte> bytes, const std::string& file,
                  const std::shared_ptr<const void>& owner) {
  std::uint64_t length = 0;
  if (bytes.size() < kLengthSize) {
    throw badInput({file, "", ""},
                   "this is not a safetensors file, it has " + std::to_string(bytes.size()) + " bytes",
                   "8 bytes of length, then a JSON header");
  }
  std::memcpy(&length, bytes.data(), kLengthSize);
  if (length > kMaxHeaderSize || length > bytes.size() - kLengthSize) {
    throw badInput({file, "header", ""}, "its length says " + std::to_string(length) + " bytes",
                   "at most 100 MB, and inside the file",
                   "make the file again, it was cut short or is something else");
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()) + kLengthSize, length);
  const Json header = text.starts_with('{') ? parseJson(text, file) : Json();
  if (!header.is_object())
    throw badInput({file, "header", ""}, "it is not a JSON object", "{\"name\": {...}, ...}");

  const auto data = bytes.subspan(kLengthSize + length);
  const HeaderReader reader(file, data.size());
  TensorFile result;
  std::vector<Placement> placements;
  for (const auto& [name, entry] : header.items()) {
    if (name == kMetadataKey) {
      result.metadata = reader.metadata(entry);
    } else {
      placements.push_back(reader.placement(name, entry));
    }
  }
  reader.checkTiling(placements);
  for (Placement& placement : placements) {
    const auto part = data.subspan(placement.begin, placement.end - placement.begin);
    const bool aligned = reinterpret_cast<std::uintptr_t>(part.data()) % sizeOf(placement.type) == 0;
    result.tensors[placement.name] = {
        placement.type, std::move(placement.shape),
        owner && aligned ? SharedBytes(part, owner) : SharedBytes(Bytes(part.begin(), part.end()))};
  }
  return result;
}

}  // namespace

TensorFile decodeSafetensors(std::span<const std::byte> bytes, const std::string& file) {
  return decode(bytes, file, nullptr);
}

void writeSafetensors(const std::filesystem::path& path, const TensorFile& file) {
  TensorWriter writer(path, shapesOf(file), file.metadata);
  for (const auto& [name, tensor] : file.tensors)
    writer.append(name, std::span<const std::byte>(tensor.data));
  writer.finish();
}

TensorFile readSafetensors(const std::filesystem::path& path) {
  std::error_code ignored;
  // A pipe has no pages to map.
  if (!std::filesystem::is_regular_file(path, ignored))
    return decodeSafetensors(readFile(path), path.string());
  const auto mapped = MappedFile::open(path);
  return decode(mapped->bytes(), path.string(), mapped);
}

}  // namespace bakelight::formats
