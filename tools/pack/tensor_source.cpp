#include "tools/pack/tensor_source.h"

#include <charconv>
#include <utility>

namespace bakelight::packing {

using formats::ElementType;
using formats::Tensor;

std::string shapeText(const std::vector<std::uint64_t>& shape) {
  std::string text;
  for (const std::uint64_t extent : shape) text += (text.empty() ? "" : " × ") + std::to_string(extent);
  return text;
}

TensorSource::TensorSource(const formats::TensorFile& tensors, std::string file, std::string remedy)
    : tensors_(tensors), file_(std::move(file)), remedy_(std::move(remedy)) {}

Error TensorSource::error(const std::string& element, const std::string& what,
                          const std::string& expected) const {
  return badInput({file_, element, ""}, what, expected, remedy_);
}

const std::string& TensorSource::text(const char* key) const {
  return tensors_.requireMetadata(key, file_);
}

void TensorSource::requireText(const char* key, const std::string& expected) const {
  if (text(key) == expected) return;
  throw error(std::string("metadata ") + key, "it is '" + text(key) + "'", "'" + expected + "'");
}

int TensorSource::order(const char* key) const {
  return integer(key, 10);
}

int TensorSource::integer(const char* key, int most) const {
  const std::string& digits = text(key);
  int value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (status == std::errc() && end == digits.data() + digits.size() && value >= 1 && value <= most)
    return value;
  throw error(std::string("metadata ") + key, "it is '" + digits + "'", "1 to " + std::to_string(most));
}

float TensorSource::number(const char* key, float most) const {
  const std::string& digits = text(key);
  float value = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (status == std::errc() && end == digits.data() + digits.size() && value >= 0 && value <= most)
    return value;
  throw error(std::string("metadata ") + key, "it is '" + digits + "'", "0 to " + std::to_string(most));
}

const Tensor& TensorSource::tensor(const char* name, std::size_t rank, ElementType type) const {
  return tensors_.require(name, type, rank, file_);
}

const Tensor& TensorSource::tensor(const char* name, const std::vector<std::uint64_t>& shape,
                                   const std::string& expected, ElementType type) const {
  const Tensor& found = tensor(name, shape.size(), type);
  if (found.shape == shape) return found;
  throw error(std::string("tensor ") + name, "its shape is " + shapeText(found.shape),
              shapeText(shape) + ", " + expected);
}

formats::EncodedTable TensorSource::table(const char* name, const Tensor& tensor, std::uint64_t columns,
                                          formats::Precision precision) const {
  return encodeTable(tensor.as<float>(), columns, precision, file_, std::string("tensor ") + name);
}

}  // namespace bakelight::packing
