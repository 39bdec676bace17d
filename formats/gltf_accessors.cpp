#include "formats/gltf_accessors.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

namespace bakelight::formats {
namespace {

constexpr std::uint64_t kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125,
                        kFloat = 5126;

// Without a view nothing bounds the count; more zeros than this make no mesh.
constexpr std::uint64_t kMostZeros = 1U << 24;

struct TypeName {
  GltfType type;
  const char* name;
};
constexpr std::array<TypeName, 5> kTypes = {{{GltfType::kScalar, "SCALAR"},
                                             {GltfType::kVector2, "VEC2"},
                                             {GltfType::kVector3, "VEC3"},
                                             {GltfType::kVector4, "VEC4"},
                                             {GltfType::kMatrix4, "MAT4"}}};

template <class Visitor>
auto visitComponent(std::uint64_t type, const Visitor& visitor) {
  switch (type) {
    case kInt8:
      return visitor(std::int8_t{});
    case kUint8:
      return visitor(std::uint8_t{});
    case kInt16:
      return visitor(std::int16_t{});
    case kUint16:
      return visitor(std::uint16_t{});
    case kUint32:
      return visitor(std::uint32_t{});
    default:
      return visitor(float{});
  }
}

// 0 if there is no such type.
std::size_t componentSize(std::uint64_t component_type) {
  switch (component_type) {
    case kInt8:
    case kUint8:
      return 1;
    case kInt16:
    case kUint16:
      return 2;
    case kUint32:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

std::uint64_t componentTypeAt(const JsonReader& value) {
  const std::uint64_t type = value.whole();
  if (componentSize(type) == 0) {
    throw value.error(std::to_string(type) + " is no component type", "5120 to 5123, 5125 or 5126");
  }
  return type;
}

double largestOf(std::uint64_t component_type) {
  return visitComponent(component_type, [](auto component) {
    return static_cast<double>(std::numeric_limits<decltype(component)>::max());
  });
}

// Elements in memory, checked to lie within their view.
struct Elements {
  const std::byte* first = nullptr;
  std::size_t stride = 0, count = 0, components = 0;
};

// `owner` has the bufferView, byteOffset and is blamed; a `packed` one has no stride.
Elements elementsOf(GltfDocument& document, const JsonReader& owner, std::uint64_t count,
                    std::size_t components, std::uint64_t component_type, const JsonReader& count_place,
                    bool packed) {
  const GltfView view = document.view(owner.at("bufferView"));
  const std::uint64_t offset = owner.whole("byteOffset", 0);
  const std::size_t size = components * componentSize(component_type);
  const std::size_t stride = packed || view.stride == 0 ? size : view.stride;
  if (stride < size) {
    throw owner.at("bufferView")
        .error("the byteStride of the view is " + std::to_string(stride) + ", its elements have " +
                   std::to_string(size) + " bytes",
               "a stride no smaller than the elements");
  }
  if (count == 0) return {nullptr, stride, 0, components};
  const std::uint64_t there = view.bytes.size();
  if (offset > there || there - offset < size || (there - offset - size) / stride < count - 1) {
    throw count_place.error(std::to_string(count) + " elements from byte " + std::to_string(offset) +
                                " on end beyond the bufferView",
                            "at most its " + std::to_string(there) + " bytes");
  }
  return {view.bytes.data() + offset, stride, static_cast<std::size_t>(count), components};
}

template <class Component>
void readElements(const Elements& elements, double scale, double least, double* out) {
  for (std::size_t i = 0; i < elements.count; ++i) {
    const std::byte* element = elements.first + i * elements.stride;
    for (std::size_t c = 0; c < elements.components; ++c) {
      Component value;
      std::memcpy(&value, element + c * sizeof(Component), sizeof(Component));
      *out++ = std::max(static_cast<double>(value) / scale, least);
    }
  }
}

void readElements(const Elements& elements, std::uint64_t component_type, bool normalized, double* out) {
  visitComponent(component_type, [&](auto component) {
    using Component = decltype(component);
    if constexpr (std::is_floating_point_v<Component>) {
      for (std::size_t i = 0; i < elements.count; ++i) {
        for (std::size_t c = 0; c < elements.components; ++c) {
          Component value;  // by hand: std::max would turn NaN into a number
          std::memcpy(&value, elements.first + i * elements.stride + c * sizeof(Component),
                      sizeof(Component));
          *out++ = static_cast<double>(value);
        }
      }
    } else {
      constexpr double kInfinity = std::numeric_limits<double>::infinity();
      const double scale = normalized ? static_cast<double>(std::numeric_limits<Component>::max()) : 1;
      readElements<Component>(elements, scale, normalized ? -1 : -kInfinity, out);
    }
  });
}

std::vector<std::uint32_t> readWhole(const Elements& elements, std::uint64_t component_type) {
  std::vector<std::uint32_t> result(elements.count);
  visitComponent(component_type, [&](auto component) {
    using Component = decltype(component);
    if constexpr (std::is_unsigned_v<Component>) {
      for (std::size_t i = 0; i < elements.count; ++i) {
        Component value;
        std::memcpy(&value, elements.first + i * elements.stride, sizeof(Component));
        result[i] = value;
      }
    }
  });
  return result;
}

std::uint64_t unsignedTypeAt(const JsonReader& value) {
  const std::uint64_t type = componentTypeAt(value);
  if (type != kUint8 && type != kUint16 && type != kUint32) {
    throw value.error("indices of component type " + std::to_string(type), "5121, 5123 or 5125");
  }
  return type;
}

std::size_t typeAt(const JsonReader& value, std::initializer_list<GltfType> types) {
  std::string expected;
  for (const auto& [type, name] : kTypes) {
    if (std::find(types.begin(), types.end(), type) == types.end()) continue;
    if (value.text() == name) return static_cast<std::size_t>(type);
    expected += (expected.empty() ? "" : " or ") + std::string(name);
  }
  throw value.error("'" + value.text() + "' cannot be used here", expected);
}

// Values that replace some of the elements (glTF 2.0, 3.6.2.3).
void applySparse(GltfDocument& document, const JsonReader& sparse, std::uint64_t component_type,
                 bool normalized, GltfNumbers& numbers) {
  const JsonReader count = sparse.at("count"), indices = sparse.at("indices");
  const std::uint64_t index_type = unsignedTypeAt(indices.at("componentType"));
  const auto places =
      readWhole(elementsOf(document, indices, count.whole(), 1, index_type, count, true), index_type);
  const Elements elements = elementsOf(document, sparse.at("values"), count.whole(), numbers.components,
                                       component_type, count, true);
  std::vector<double> values(elements.count * numbers.components);
  readElements(elements, component_type, normalized, values.data());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] >= numbers.count()) {
      throw indices.error("index " + std::to_string(i) + " is " + std::to_string(places[i]),
                          "below the accessor's count, " + std::to_string(numbers.count()));
    }
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * numbers.components), numbers.components,
                numbers.values.begin() + static_cast<std::ptrdiff_t>(places[i] * numbers.components));
  }
}

}  // namespace

std::size_t accessorCount(GltfDocument& document, const JsonReader& reference) {
  return static_cast<std::size_t>(document.referred(reference, "accessors").at("count").whole());
}

GltfNumbers readNumbers(GltfDocument& document, const JsonReader& reference,
                        std::initializer_list<GltfType> types, std::optional<std::size_t> expected_count) {
  const JsonReader accessor = document.referred(reference, "accessors");
  const JsonReader count = accessor.at("count");
  const std::uint64_t component_type = componentTypeAt(accessor.at("componentType"));
  const bool normalized = accessor.boolean("normalized", false);
  GltfNumbers numbers;
  numbers.components = typeAt(accessor.at("type"), types);
  if (!normalized && component_type != kFloat) numbers.code_range = largestOf(component_type);
  if (expected_count && count.whole() != *expected_count) {
    throw count.error(std::to_string(count.whole()) + " elements",
                      std::to_string(*expected_count) + ", as its other attributes have");
  }
  if (accessor.find("bufferView")) {
    const Elements elements =
        elementsOf(document, accessor, count.whole(), numbers.components, component_type, count, false);
    numbers.values.resize(elements.count * numbers.components);
    readElements(elements, component_type, normalized, numbers.values.data());
  } else {
    if (count.whole() > kMostZeros) {
      throw count.error(std::to_string(count.whole()) + " elements without a bufferView",
                        "at most " + std::to_string(kMostZeros));
    }
    numbers.values.assign(static_cast<std::size_t>(count.whole()) * numbers.components, 0);
  }
  if (const auto sparse = accessor.find("sparse")) {
    applySparse(document, *sparse, component_type, normalized, numbers);
  }
  return numbers;
}

std::vector<std::uint32_t> readIndices(GltfDocument& document, const JsonReader& reference, std::size_t limit,
                                       const char* what) {
  const JsonReader accessor = document.referred(reference, "accessors");
  typeAt(accessor.at("type"), {GltfType::kScalar});
  const std::uint64_t type = unsignedTypeAt(accessor.at("componentType"));
  const JsonReader count = accessor.at("count");
  std::vector<std::uint32_t> indices;
  if (!accessor.find("bufferView") || accessor.find("sparse")) {  // rare: by the general way
    const GltfNumbers numbers = readNumbers(document, reference, {GltfType::kScalar});
    indices.assign(numbers.values.begin(), numbers.values.end());
  } else {
    indices = readWhole(elementsOf(document, accessor, count.whole(), 1, type, count, false), type);
  }
  const std::uint64_t restart = (std::uint64_t{1} << (8 * componentSize(type))) - 1;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] < limit && indices[i] != restart) continue;
    const std::string number = std::to_string(indices[i]);
    throw accessor.error(
        "index " + std::to_string(i) + " is " + number +
            (indices[i] == restart ? ", which would restart a primitive"
                                   : ", and " + std::string(what) + " " + number + " does not exist"),
        "indices below " + std::to_string(std::min<std::uint64_t>(limit, restart)));
  }
  return indices;
}

}  // namespace bakelight::formats
