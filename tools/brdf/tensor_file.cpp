#include "tools/brdf/tensor_file.h"

#include <cstring>

#include "formats/error.h"

namespace bakelight::brdf {
namespace {

constexpr std::size_t kSizes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};  // of an element, by type
constexpr std::size_t kMostDimensions = 8;
constexpr char kBegin[] = "tensor_file";  // with its NUL

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  template <class T>
  T read() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  std::span<const std::byte> take(std::size_t count) {
    if (count > bytes_.size() - offset_)
      throw badInput({file_, "offset " + std::to_string(offset_), ""},
                     "the file ends within its list of fields", std::to_string(count) + " bytes more",
                     "check that the download is whole");
    offset_ += count;
    return bytes_.subspan(offset_ - count, count);
  }

 private:
  std::span<const std::byte> bytes_;
  const std::string& file_;
  std::size_t offset_ = 0;
};

}  // namespace

std::map<std::string, TensorField> readTensorFields(std::span<const std::byte> bytes,
                                                    const std::string& file) {
  if (bytes.size() < sizeof(kBegin) || std::memcmp(bytes.data(), kBegin, sizeof(kBegin)) != 0)
    throw badInput({file, "offset 0", ""}, "it does not begin as a tensor file", "\"tensor_file\"",
                   "take a .bsdf file of the RGL material database");
  Reader reader(bytes, file);
  reader.take(sizeof(kBegin));
  const int major = reader.read<std::uint8_t>(), minor = reader.read<std::uint8_t>();
  if (major != 1 || minor != 0)
    throw badInput({file, "offset 12", ""},
                   "it has version " + std::to_string(major) + "." + std::to_string(minor), "1.0");
  const auto count = reader.read<std::uint32_t>();
  std::map<std::string, TensorField> fields;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto name_bytes = reader.take(reader.read<std::uint16_t>());
    const std::string name(reinterpret_cast<const char*>(name_bytes.data()), name_bytes.size());
    const auto wrong = [&](const std::string& what, const std::string& expected) {
      return badInput({file, "field " + name, ""}, what, expected, "check that the download is whole");
    };
    TensorField field;
    const std::size_t dimensions = reader.read<std::uint16_t>();
    field.type = reader.read<std::uint8_t>();
    const auto offset = reader.read<std::uint64_t>();
    if (field.type < 1 || field.type > 11)
      throw wrong("its type is " + std::to_string(field.type), "1 to 11");
    if (dimensions > kMostDimensions)
      throw wrong("it has " + std::to_string(dimensions) + " dimensions", "8 or fewer");
    std::uint64_t size = kSizes[field.type];
    bool fits = true;
    for (std::size_t d = 0; d < dimensions; ++d) {
      field.shape.push_back(reader.read<std::uint64_t>());
      fits = fits && !__builtin_mul_overflow(size, field.shape.back(), &size);
    }
    if (!fits || offset > bytes.size() || size > bytes.size() - offset)
      throw wrong("its " + (fits ? std::to_string(size) : "too many") + " bytes at " +
                      std::to_string(offset) + " lie beyond the end of the file",
                  "at most " + std::to_string(bytes.size()) + " bytes");
    field.bytes = bytes.subspan(offset, size);
    field.count = size / kSizes[field.type];
    if (!fields.emplace(name, field).second) throw wrong("it is there twice", "one");
  }
  return fields;
}

}  // namespace bakelight::brdf
