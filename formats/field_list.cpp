#include "formats/field_list.h"

namespace bakelight::formats {
namespace {

class Collector final : public FieldVisitor {
 public:
  std::vector<FieldValue> take() { return std::move(fields_); }

  void integer(const char* name, int& value, const Range&) override { add(name, value); }
  void number(const char* name, float& value, const Range&) override { add(name, value); }
  void vector(const char* name, Float3& value, const Range&) override { add(name, value); }
  void constant(const char*, const char*) override {}
  void choice(const char* name, int& value, std::span<const char* const> names) override {
    add(name, names[static_cast<std::size_t>(value)]);
  }
  void table(const char* name, EncodedTable& table, Rows, std::size_t) override {
    fields_.push_back({prefix_ + name, {}, &table});
  }
  void floats(const char* name, std::vector<float>& values, std::size_t) override {
    FieldValue& field = fields_.emplace_back();
    field.name = prefix_ + name;
    field.values = values;
  }
  void integers(const char* name, IntegerArray& values, std::size_t) override {
    FieldValue& field = fields_.emplace_back();
    field.name = prefix_ + name;
    field.integers = &values;
  }
  void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t) override {
    add(name, values);
  }
  void tangents(const char* name, std::vector<Float4>& values) override {
    std::vector<float> components;
    for (const Float4& t : values) components.insert(components.end(), t.begin(), t.end());
    FieldValue& field = fields_.emplace_back();
    field.name = prefix_ + name;
    field.values = std::move(components);
  }
  void image(const char* name, PackImage& image) override {
    add((std::string(name) + ".size").c_str(), Json{image.width, image.height});
    add((std::string(name) + ".channels").c_str(), image.channels);
    fields_.push_back({prefix_ + name, {}, &image.texels});
  }
  bool open(const char* name, bool is_there) override {
    if (!is_there) return false;
    lengths_.push_back(prefix_.size());
    prefix_ += std::string(name) + ".";
    return true;
  }
  void close() override {
    prefix_.resize(lengths_.back());
    lengths_.pop_back();
  }
  void require(bool, const char*, const std::string&, const std::string&, const std::string&) override {}

 private:
  void add(const char* name, Json value) {
    FieldValue& field = fields_.emplace_back();
    field.name = prefix_ + name;
    field.plain = std::move(value);
  }

  std::string prefix_;
  std::vector<std::size_t> lengths_;
  std::vector<FieldValue> fields_;
};

}  // namespace

std::vector<FieldValue> fieldsOf(const PackPart& part) {
  Collector collector;
  const_cast<PackPart&>(part).describe(collector);  // it only looks
  return collector.take();
}

}  // namespace bakelight::formats
