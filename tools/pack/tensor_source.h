// A tensor file whose statements are checked as they are read; every error names file and tensor or key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/error.h"
#include "formats/tensors.h"

namespace bakelight::packing {

// "3 × 1 × 25"
std::string shapeText(const std::vector<std::uint64_t>& shape);

inline std::uint64_t squared(int order) {
  return static_cast<std::uint64_t>(order) * static_cast<std::uint64_t>(order);
}

class TensorSource {
 public:
  // `remedy` is what to do about a file that is wrong. `tensors` must outlive the source.
  TensorSource(const formats::TensorFile& tensors, std::string file, std::string remedy);

  const formats::TensorFile& tensors() const { return tensors_; }
  const std::string& file() const { return file_; }
  Error error(const std::string& element, const std::string& what, const std::string& expected) const;

  // All of these throw Error(kBadInput).
  const std::string& text(const char* key) const;
  void requireText(const char* key, const std::string& expected) const;
  int order(const char* key) const;                 // 1–10
  int integer(const char* key, int most) const;     // 1–most
  float number(const char* key, float most) const;  // 0–most

  bool has(const char* name) const { return tensors_.tensors.contains(name); }
  const formats::Tensor& tensor(const char* name, std::size_t rank,
                                formats::ElementType type = formats::ElementType::kFloat32) const;
  // `expected` says in words what the extents are.
  const formats::Tensor& tensor(const char* name, const std::vector<std::uint64_t>& shape,
                                const std::string& expected,
                                formats::ElementType type = formats::ElementType::kFloat32) const;
  // A tensor of floats as rows of `columns` values.
  formats::EncodedTable table(const char* name, const formats::Tensor& tensor, std::uint64_t columns,
                              formats::Precision precision) const;

 private:
  const formats::TensorFile& tensors_;
  std::string file_, remedy_;
};

}  // namespace bakelight::packing
