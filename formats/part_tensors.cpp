#include "formats/part_tensors.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

#include "formats/error.h"

namespace bakelight::formats {
namespace {

constexpr const char* kPartKey = "part";

ElementType typeOf(Precision precision) {
  switch (precision) {
    case Precision::kFloat32:
      return ElementType::kFloat32;
    case Precision::kFloat16:
      return ElementType::kFloat16;
    case Precision::kUint8:
      return ElementType::kUint8;
  }
  return ElementType::kFloat32;
}

std::string textOf(double value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(9);
  text << value;
  return text.str();
}

// Names as they are within groups.
class Named : public FieldVisitor {
 public:
  void constant(const char*, const char*) override {}
  void choice(const char*, int&, std::span<const char* const>) override {
    throw std::logic_error("a part in a file of its own has no choices");
  }
  void tangents(const char*, std::vector<Float4>&) override {
    throw std::logic_error("a part in a file of its own has no tangents");
  }
  void image(const char*, PackImage&) override {
    throw std::logic_error("a part in a file of its own has no images");
  }
  void close() override {
    prefix_.resize(lengths_.back());
    lengths_.pop_back();
  }

 protected:
  std::string named(const char* name) const { return prefix_ + name; }
  void enter(const char* name) {
    lengths_.push_back(prefix_.size());
    prefix_ += std::string(name) + ".";
  }

 private:
  std::string prefix_;
  std::vector<std::size_t> lengths_;
};

class Writer final : public Named {
 public:
  TensorFile file;

  void integer(const char* name, int& value, const Range&) override {
    file.metadata[named(name)] = std::to_string(value);
  }
  void number(const char* name, float& value, const Range&) override {
    file.metadata[named(name)] = textOf(static_cast<double>(value));
  }
  void vector(const char* name, Float3& value, const Range&) override {
    file.tensors[named(name)] = Tensor::from<float>(ElementType::kFloat32, {value.size()}, value);
  }
  void table(const char* name, EncodedTable& table, Rows, std::size_t columns) override {
    if (table.precision == Precision::kUint8)
      throw std::logic_error("tables in a file of their own are of floats");
    file.tensors[named(name)] = {typeOf(table.precision), {table.rows, columns}, table.data};
  }
  void floats(const char* name, std::vector<float>& values, std::size_t) override {
    file.tensors[named(name)] = Tensor::from<float>(ElementType::kFloat32, {values.size()}, values);
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    if (values.width != 4) throw std::logic_error("integers in a file of their own have 4 bytes");
    file.tensors[named(name)] = {ElementType::kUint32, {values.count()}, values.data};
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t) override {
    file.tensors[named(name)] = Tensor::from<std::uint32_t>(ElementType::kUint32, {values.size()}, values);
  }
  bool open(const char* name, bool is_there) override {
    if (is_there) enter(name);
    return is_there;
  }
  void require(bool holds, const char* name, const std::string& what, const std::string&,
               const std::string&) override {
    if (!holds) throw std::logic_error(named(name) + ": " + what);
  }
};

class Reader final : public Named {
 public:
  Reader(const TensorFile& tensors, const std::string& file) : tensors_(tensors), file_(file) {}

  void integer(const char* name, int& value, const Range& range) override {
    const double number = numberOf(name, range);
    if (number != std::floor(number)) refuse(name, "it is no whole number", formats::textOf(range));
    value = static_cast<int>(number);
  }
  void number(const char* name, float& value, const Range& range) override {
    value = static_cast<float>(numberOf(name, range));
  }
  void vector(const char* name, Float3& value, const Range& range) override {
    const auto found = listOf<float>(name, ElementType::kFloat32);
    if (found.size() != value.size())
      refuse(name, "it has " + std::to_string(found.size()) + " values", std::to_string(value.size()));
    for (std::size_t i = 0; i < value.size(); ++i)
      if (!range.holds(value[i] = found[i]))
        refuse(name, "value " + std::to_string(i) + " is " + textOf(static_cast<double>(found[i])),
               formats::textOf(range));
  }
  void table(const char* name, EncodedTable& table, Rows, std::size_t columns) override {
    const Tensor& tensor = find(name);
    const bool halves = tensor.type == ElementType::kFloat16;
    if ((!halves && tensor.type != ElementType::kFloat32) || tensor.shape.size() != 2 ||
        tensor.shape[1] != columns)
      refuse(name, "it is no table of floats with " + std::to_string(columns) + " columns", "one");
    table = {
        halves ? Precision::kFloat16 : Precision::kFloat32, tensor.shape[0], columns, tensor.data, {}, {}};
    for (const float value : table.decode())
      if (!std::isfinite(value)) refuse(name, "it holds a value that is not finite", "finite numbers");
  }
  void floats(const char* name, std::vector<float>& values, std::size_t count) override {
    const auto found = listOf<float>(name, ElementType::kFloat32);
    if (found.size() != count)
      refuse(name, "it has " + std::to_string(found.size()) + " values", std::to_string(count));
    values.assign(found.begin(), found.end());
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    listOf<std::uint32_t>(name, ElementType::kUint32);
    values = {4, find(name).data};
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t end) override {
    const auto found = listOf<std::uint32_t>(name, ElementType::kUint32);
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found[i] >= end)
        refuse(name, "value " + std::to_string(i) + " is " + std::to_string(found[i]),
               "below " + std::to_string(end));
    values.assign(found.begin(), found.end());
  }
  bool open(const char* name, bool) override {
    const std::string prefix = named(name) + ".";
    const auto first = tensors_.tensors.lower_bound(prefix);
    if (first == tensors_.tensors.end() || !first->first.starts_with(prefix)) return false;
    enter(name);
    return true;
  }
  void require(bool holds, const char* name, const std::string& what, const std::string& expected,
               const std::string& remedy) override {
    if (!holds) throw badInput({file_, named(name), ""}, what, expected, remedy);
  }

 private:
  [[noreturn]] void refuse(const char* name, const std::string& what, const std::string& expected) const {
    throw badInput({file_, named(name), ""}, what, expected);
  }
  const Tensor& find(const char* name) const {
    const auto found = tensors_.tensors.find(named(name));
    if (found == tensors_.tensors.end()) refuse(name, "there is no such tensor", "one");
    return found->second;
  }
  template <class T>
  std::span<const T> listOf(const char* name, ElementType type) const {
    const Tensor& tensor = find(name);
    if (tensor.type != type || tensor.shape.size() != 1)
      refuse(name, "it is no list of " + std::string(safetensorsName(type)), "one");
    return tensor.as<T>();
  }
  double numberOf(const char* name, const Range& range) const {
    std::istringstream text(tensors_.requireMetadata(named(name), file_));
    text.imbue(std::locale::classic());
    double value = 0;
    if (!(text >> value) || !range.holds(value))
      refuse(name, "it is no number that may be there", formats::textOf(range));
    return value;
  }

  const TensorFile& tensors_;
  const std::string& file_;
};

}  // namespace

TensorFile tensorsOf(PackPart& part) {
  Writer writer;
  part.describe(writer);
  writer.file.metadata[kPartKey] = part.kind();
  return std::move(writer.file);
}

void readPart(PackPart& part, const TensorFile& tensors, const std::string& file) {
  const std::string& kind = tensors.requireMetadata(kPartKey, file);
  if (kind != part.kind()) throw badInput({file, kPartKey, ""}, "it is of " + kind, part.kind());
  Reader reader(tensors, file);
  part.describe(reader);
}

}  // namespace bakelight::formats
