#include "formats/gltf_draco.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <algorithm>
#include <cstring>
#include <limits>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace bakelight::formats {
namespace {

template <class Component>
bool readAttribute(const draco::PointAttribute& attribute, std::size_t points, bool normalized,
                   GltfNumbers& numbers) {
  const bool is_integer = std::numeric_limits<Component>::is_integer;
  const double largest = static_cast<double>(std::numeric_limits<Component>::max());
  const double scale = is_integer && normalized ? largest : 1;
  if (is_integer && !normalized) numbers.code_range = largest;
  const std::size_t size = numbers.components * sizeof(Component);
  const auto stride = static_cast<std::size_t>(attribute.byte_stride());
  if (stride < size || attribute.byte_offset() < 0 || attribute.buffer() == nullptr ||
      attribute.buffer()->data_size() <
          static_cast<std::size_t>(attribute.byte_offset()) + attribute.size() * stride) {
    return false;
  }
  numbers.values.resize(points * numbers.components);
  double* out = numbers.values.data();
  for (std::uint32_t i = 0; i < points; ++i) {
    const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
    if (index.value() >= attribute.size()) return false;
    const std::uint8_t* element = attribute.GetAddress(index);
    for (std::size_t c = 0; c < numbers.components; ++c) {
      Component value;
      std::memcpy(&value, element + c * sizeof(Component), sizeof(Component));
      const double number = static_cast<double>(value) / scale;
      *out++ = is_integer && normalized && number < -1 ? -1 : number;
    }
  }
  return true;
}

bool readAttribute(const draco::PointAttribute& attribute, std::size_t points, bool normalized,
                   GltfNumbers& numbers) {
  switch (attribute.data_type()) {
    case draco::DT_INT8:
      return readAttribute<std::int8_t>(attribute, points, normalized, numbers);
    case draco::DT_UINT8:
      return readAttribute<std::uint8_t>(attribute, points, normalized, numbers);
    case draco::DT_INT16:
      return readAttribute<std::int16_t>(attribute, points, normalized, numbers);
    case draco::DT_UINT16:
      return readAttribute<std::uint16_t>(attribute, points, normalized, numbers);
    case draco::DT_INT32:
      return readAttribute<std::int32_t>(attribute, points, normalized, numbers);
    case draco::DT_UINT32:
      return readAttribute<std::uint32_t>(attribute, points, normalized, numbers);
    case draco::DT_FLOAT32:
      return readAttribute<float>(attribute, points, normalized, numbers);
    case draco::DT_FLOAT64:
      return readAttribute<double>(attribute, points, normalized, numbers);
    default:
      return false;
  }
}

}  // namespace

struct GltfDraco::Decoded {
  std::unique_ptr<draco::Mesh> mesh;
};

GltfDraco::GltfDraco(GltfDocument& document, const JsonReader& extension)
    : extension_(extension), decoded_(std::make_unique<Decoded>()) {
  const auto bytes = document.view(extension.at("bufferView")).bytes;
  const auto undecodable = [&](const std::string& why) {
    return extension.error("Draco cannot decode it (" + why + ")", "a Draco mesh");
  };
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  try {
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok()) throw undecodable(result.status().error_msg());
    decoded_->mesh = std::move(result).value();
  } catch (const std::bad_alloc&) {  // sizes of a damaged file
    throw undecodable("more memory asked for than there is");
  } catch (const std::length_error&) {
    throw undecodable("more memory asked for than there can be");
  }
  for (const Triangle& triangle : triangles()) {
    if (std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return v >= vertexCount(); }))
      throw undecodable("a face names a vertex that does not exist");
  }
}

GltfDraco::~GltfDraco() = default;

std::size_t GltfDraco::vertexCount() const {
  return decoded_->mesh->num_points();
}

std::vector<Triangle> GltfDraco::triangles() const {
  std::vector<Triangle> result;
  result.reserve(decoded_->mesh->num_faces());
  for (std::uint32_t i = 0; i < decoded_->mesh->num_faces(); ++i) {
    const auto& face = decoded_->mesh->face(draco::FaceIndex(i));
    result.push_back({face[0].value(), face[1].value(), face[2].value()});
  }
  return result;
}

std::optional<GltfNumbers> GltfDraco::numbers(const std::string& name, const JsonReader& accessor,
                                              std::initializer_list<GltfType> types) const {
  const auto id = extension_.at("attributes").find(name);
  if (!id) return std::nullopt;
  const draco::PointAttribute* attribute =
      id->whole() > 0xFFFFFFFFU
          ? nullptr
          : decoded_->mesh->GetAttributeByUniqueId(static_cast<std::uint32_t>(id->whole()));
  if (attribute == nullptr) {
    throw id->error("Draco has no attribute " + std::to_string(id->whole()), "the unique id of an attribute");
  }
  GltfNumbers numbers;
  numbers.components = static_cast<std::size_t>(attribute->num_components());
  const bool fits = std::any_of(types.begin(), types.end(), [&](GltfType type) {
    return static_cast<std::size_t>(type) == numbers.components;
  });
  const bool normalized = attribute->normalized() || accessor.boolean("normalized", false);
  if (!fits || !readAttribute(*attribute, vertexCount(), normalized, numbers)) {
    throw id->error("Draco's attribute " + std::to_string(id->whole()) + " has " +
                        std::to_string(numbers.components) + " components of type " +
                        std::to_string(attribute->data_type()),
                    "those of " + name);
  }
  return numbers;
}

}  // namespace bakelight::formats
