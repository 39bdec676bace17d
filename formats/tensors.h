// Named arrays in safetensors files: 8-byte length, JSON header, raw little-endian data. One line of Python
// reads them:
//   safetensors.numpy.load_file("transfer.safetensors")
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "formats/file.h"
#include "formats/shared_bytes.h"

namespace bakelight::formats {

enum class ElementType { kFloat32, kFloat16, kFloat64, kUint8, kUint16, kUint32, kInt32, kInt64 };

std::size_t sizeOf(ElementType type);           // bytes
const char* safetensorsName(ElementType type);  // "F32", "F16", ...

// Row-major ("C order").
struct Tensor {
  ElementType type = ElementType::kFloat32;
  std::vector<std::uint64_t> shape;
  SharedBytes data;

  std::uint64_t elementCount() const;
  // The data as T. T's size must be that of `type`, and `shape` must hold as many values (both checked,
  // std::logic_error).
  template <class T>
  std::span<const T> as() const;
  template <class T>
  static Tensor from(ElementType type, std::vector<std::uint64_t> shape, std::span<const T> values);
};

struct TensorFile {
  std::map<std::string, Tensor> tensors;
  std::map<std::string, std::string> metadata;  // units, order, provenance

  // Throws Error(kBadInput) if there is no such tensor, or its type or rank differs.
  const Tensor& require(const std::string& name, ElementType type, std::size_t rank,
                        const std::string& file) const;
  // Throws Error(kBadInput) if there is no such key.
  const std::string& requireMetadata(const std::string& key, const std::string& file) const;
};

Bytes encodeSafetensors(const TensorFile& file);
// Throws Error(kBadInput) naming file and tensor: truncated, header not JSON or larger than 100 MB, offsets
// that overlap, leave holes, run past the end or disagree with shape × size, sizes that overflow when
// multiplied.
TensorFile decodeSafetensors(std::span<const std::byte> bytes, const std::string& file);

void writeSafetensors(const std::filesystem::path& path, const TensorFile& file);  // atomic
// The tensors point into the file, which is mapped (mapped_file.h): opening it takes no memory. Only an array
// that another program put at an odd place is copied. Throws as decodeSafetensors.
TensorFile readSafetensors(const std::filesystem::path& path);

struct TensorShape {
  ElementType type = ElementType::kFloat32;
  std::vector<std::uint64_t> shape;
};
// The bytes of a file before its data, and where the data of each array are behind them.
struct TensorLayout {
  struct Place {
    std::uint64_t begin, end;
  };
  Bytes header;
  std::vector<std::pair<std::string, Place>> places;  // in their order
};
// Throws std::logic_error for sizes that overflow, and Error(kBadInput) for text that is not UTF-8.
TensorLayout layOutTensors(const std::map<std::string, TensorShape>& tensors,
                           const std::map<std::string, std::string>& metadata);

template <class T>
std::span<const T> Tensor::as() const {
  if (sizeof(T) != sizeOf(type)) throw std::logic_error("a tensor is not read as the type it has");
  return {reinterpret_cast<const T*>(data.data()), data.size() / sizeof(T)};
}

template <class T>
Tensor Tensor::from(ElementType type, std::vector<std::uint64_t> shape, std::span<const T> values) {
  const auto bytes = std::as_bytes(values);
  Tensor tensor{type, std::move(shape), Bytes(bytes.begin(), bytes.end())};
  if (sizeof(T) != sizeOf(type) || tensor.elementCount() != values.size()) {
    throw std::logic_error("a tensor's values do not fit its type and shape");
  }
  return tensor;
}

}  // namespace bakelight::formats
