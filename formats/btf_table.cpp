#include "formats/btf_table.h"

#include <cmath>
#include <Eigen/Core>
#include <map>

#include "formats/error.h"
#include "formats/pixel_transfer.h"

namespace bakelight::formats {
namespace {

constexpr const char* kOwn = "btf";
constexpr const char* kNamed = "btf/";
constexpr float kLargestHalf = 65504;

std::string tensorOf(const std::string& material) {
  return material.empty() ? kOwn : kNamed + material;
}

std::map<std::string, TensorShape> tensorsOf(const std::vector<BtfTableShape>& shapes) {
  std::map<std::string, TensorShape> tensors;
  for (const BtfTableShape& shape : shapes)
    tensors[tensorOf(shape.material)] = {
        ElementType::kFloat16,
        {static_cast<std::uint64_t>(shape.views) * static_cast<std::uint64_t>(shape.views),
         static_cast<std::uint64_t>(shape.height), static_cast<std::uint64_t>(shape.width), 3,
         shape.cells()}};
  return tensors;
}

// The side of a grid of so many cells, up to `most`; 0 if there is none.
int sideOf(std::uint64_t cells, int most) {
  for (int side = 1; side <= most; ++side)
    if (static_cast<std::uint64_t>(side) * static_cast<std::uint64_t>(side) == cells) return side;
  return 0;
}

}  // namespace

std::vector<float> BtfTable::valuesOf(std::size_t view) const {
  const std::size_t count = valueCount() / (static_cast<std::size_t>(views) * views);
  const auto bits = halves.as<std::uint16_t>().subspan(view * count, count);
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits[i]));
  return values;
}

std::vector<BtfTable> readBtfTables(const std::filesystem::path& path) {
  constexpr int kMostViews = 64, kMostTexels = 16384;
  const TensorFile file = readSafetensors(path);
  std::vector<BtfTable> tables;
  for (const auto& [name, tensor] : file.tensors) {
    if (name != kOwn && !name.starts_with(kNamed)) continue;
    const auto error = [&, &name = name](const std::string& what, const std::string& expected) {
      return badInput({path.string(), "tensor " + name, ""}, what, expected,
                      "make it by rtt or btf of this version");
    };
    file.require(name, ElementType::kFloat16, 5, path.string());
    BtfTable table;
    table.material = name == kOwn ? "" : name.substr(std::string(kNamed).size());
    table.file = path.string();
    table.views = sideOf(tensor.shape[0], kMostViews);
    table.lights = sideOf(tensor.shape[4], kMostLocalSide);
    if (table.views == 0 || table.lights == 0 || tensor.shape[3] != 3 || tensor.shape[1] < 1 ||
        tensor.shape[1] > kMostTexels || tensor.shape[2] < 1 || tensor.shape[2] > kMostTexels)
      throw error("its shape is none of a BTF", "views² × height × width × 3 × lights²");
    table.height = static_cast<int>(tensor.shape[1]);
    table.width = static_cast<int>(tensor.shape[2]);
    table.halves = tensor;
    for (const std::uint16_t bits : tensor.as<std::uint16_t>())
      if ((bits & 0x7C00) == 0x7C00) throw error("a value is not finite", "numbers");
    tables.push_back(std::move(table));
  }
  if (tables.empty())
    throw badInput({path.string(), "", ""}, "it has no BTF", "tensors btf or btf/NAME",
                   "make it by rtt or btf with their output btfs");
  return tables;
}

BtfTableWriter::BtfTableWriter(const std::filesystem::path& path, const std::vector<BtfTableShape>& shapes)
    : file_(path.string()),
      writer_(path, tensorsOf(shapes), {{"cosine", "inside"}, {"basis", "hemisphere_cells"}}) {}

void BtfTableWriter::append(const std::string& material, std::span<const float> values) {
  std::vector<std::uint16_t> halves(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(std::abs(values[i]) <= kLargestHalf))
      throw badInput({file_, "tensor " + tensorOf(material), ""},
                     std::to_string(values[i]) + " does not fit a half float", "-65504 to 65504",
                     "make the material darker");
    halves[i] = Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(values[i]));
  }
  writer_.append(tensorOf(material), std::span<const std::uint16_t>(halves));
}

void BtfTableWriter::append(const BtfTable& table) {
  writer_.append(tensorOf(table.material), table.halves.as<std::uint16_t>());
}

}  // namespace bakelight::formats
