#include "formats/gltf_primitives.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "formats/gltf_accessors.h"
#include "formats/gltf_draco.h"

namespace bakelight::formats {
namespace {

enum Mode : std::uint64_t { kTriangles = 4, kStrip = 5, kFan = 6 };

std::vector<Double3> toDouble3(const GltfNumbers& numbers) {
  std::vector<Double3> result(numbers.count());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double* v = numbers.values.data() + i * numbers.components;
    result[i] = {v[0], v[1], v[2]};
  }
  return result;
}

class PrimitiveReader {
 public:
  PrimitiveReader(GltfDocument& document, GltfMaterials& materials, GltfCounts& counts,
                  const JsonReader& primitive, const std::vector<double>& morph_weights)
      : document_(document),
        materials_(materials),
        counts_(counts),
        primitive_(primitive),
        attributes_(primitive.at("attributes")),
        morph_weights_(morph_weights) {}

  // Nothing for points and lines.
  std::optional<GltfPrimitive> read() {
    const std::uint64_t mode = primitive_.whole("mode", kTriangles);
    if (mode > kFan) throw primitive_.at("mode").error(std::to_string(mode) + " is no mode", "0 to 6");
    if (mode < kTriangles) {
      ++counts_.points_and_lines;
      return std::nullopt;
    }
    if (!attributes_.find("POSITION")) return std::nullopt;  // legal: extensions may supply the vertices
    checkTargets();
    if (const auto packed = extensionOf(primitive_, "KHR_draco_mesh_compression")) {
      draco_ = std::make_unique<GltfDraco>(document_, *packed);
      vertex_count_ = draco_->vertexCount();
    } else {
      vertex_count_ = accessorCount(document_, attributes_.at("POSITION"));
    }
    result_.pointer = primitive_.pointer();
    result_.positions = toDouble3(attribute("POSITION", {GltfType::kVector3}));
    if (attributes_.find("NORMAL")) result_.normals = toDouble3(attribute("NORMAL", {GltfType::kVector3}));
    readTriangles(mode);
    readColors();
    readMaterial();
    readInfluences();
    return std::move(result_);
  }

 private:
  void checkTargets() const {
    const auto targets = primitive_.find("targets");
    const std::size_t count = targets ? targets->size() : 0;
    if (morph_weights_.empty() || morph_weights_.size() == count) return;
    throw primitive_.error("it has " + std::to_string(count) + " morph targets, but there are " +
                               std::to_string(morph_weights_.size()) + " weights",
                           "one weight for each");
  }

  // With its morph targets added.
  GltfNumbers attribute(const std::string& name, std::initializer_list<GltfType> types) {
    const JsonReader reference = attributes_.at(name);
    std::optional<GltfNumbers> compressed;
    if (draco_ != nullptr) {
      compressed = draco_->numbers(name, document_.referred(reference, "accessors"), types);
    }
    GltfNumbers numbers =
        compressed ? *std::move(compressed) : readNumbers(document_, reference, types, vertex_count_);
    for (std::size_t t = 0; t < morph_weights_.size(); ++t) {
      if (morph_weights_[t] == 0) continue;
      const auto target = primitive_.at("targets").at(t).find(name);
      if (target) addTarget(*target, types, morph_weights_[t], numbers);
    }
    return numbers;
  }

  void addTarget(const JsonReader& target, std::initializer_list<GltfType> types, double weight,
                 GltfNumbers& numbers) {
    const GltfNumbers moved = readNumbers(document_, target, types, vertex_count_);
    for (std::size_t i = 0; i < vertex_count_; ++i) {
      for (std::size_t c = 0; c < std::min(numbers.components, moved.components); ++c) {
        numbers.values[i * numbers.components + c] += weight * moved.values[i * moved.components + c];
      }
    }
  }

  void readTriangles(std::uint64_t mode) {
    if (draco_ != nullptr) {
      result_.part.triangles = draco_->triangles();  // of strips, too
      return;
    }
    std::vector<std::uint32_t> corners;
    if (const auto indices = primitive_.find("indices")) {
      corners = readIndices(document_, *indices, vertex_count_, "vertex");
    } else {
      if (vertex_count_ > std::numeric_limits<std::uint32_t>::max()) {
        throw primitive_.error("it has " + std::to_string(vertex_count_) + " vertices",
                               "at most 4,294,967,295");
      }
      corners.resize(vertex_count_);
      for (std::uint32_t i = 0; i < corners.size(); ++i) corners[i] = i;
    }
    if (mode == kTriangles) {
      makeTriangles(corners);
    } else {
      makeStripOrFan(corners, mode);
    }
  }

  void makeTriangles(const std::vector<std::uint32_t>& corners) {
    auto& triangles = result_.part.triangles;
    triangles.resize(corners.size() / 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      triangles[t] = {corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]};
    }
    counts_.leftover_corners += corners.size() % 3;
  }

  // glTF 2.0, 3.7.2.1. Triangles with two equal corners only lead a strip from one place to another.
  void makeStripOrFan(const std::vector<std::uint32_t>& corners, std::uint64_t mode) {
    for (std::size_t i = 0; i + 2 < corners.size(); ++i) {
      Triangle triangle = {corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]};
      if (mode == kFan) triangle = {corners[i + 1], corners[i + 2], corners[0]};
      if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
      result_.part.triangles.push_back(triangle);
    }
    if (corners.size() < 3) counts_.leftover_corners += corners.size();
  }

  void readColors() {
    if (!attributes_.find("COLOR_0")) return;
    const GltfNumbers numbers = attribute("COLOR_0", {GltfType::kVector3, GltfType::kVector4});
    const double scale = numbers.code_range > 0 ? numbers.code_range : 1;
    counts_.colors_as_codes += numbers.code_range > 0;
    result_.part.colors.resize(vertex_count_);
    for (std::size_t i = 0; i < vertex_count_; ++i) {
      const double* color = numbers.values.data() + i * numbers.components;
      result_.part.colors[i] = rounded({color[0] / scale, color[1] / scale, color[2] / scale});
    }
  }

  void readMaterial() {
    if (attributes_.find("TEXCOORD_0")) result_.part.texcoords = texcoords(0, GltfLookup{});
    const auto reference = primitive_.find("material");
    if (!reference) return;
    const std::size_t index = document_.indexAt(*reference, "materials");
    result_.part.material = static_cast<int>(index);
    const auto& lookup = materials_.use(index);
    if (!lookup) return;
    const std::string set = "TEXCOORD_" + std::to_string(lookup->set);
    if (!attributes_.find(set)) {
      throw attributes_.error("its material looks its texture up in " + set + ", which is not there",
                              "texture coordinates for a material with a texture",
                              "unwrap the mesh, or take the texture off the material");
    }
    if (!lookup->isPlain()) result_.part.texture_lookups = texcoords(lookup->set, *lookup);
  }

  // Ours begin at the lower left, glTF's at the upper left.
  std::vector<Float2> texcoords(std::uint64_t set, const GltfLookup& lookup) {
    const GltfNumbers numbers = attribute("TEXCOORD_" + std::to_string(set), {GltfType::kVector2});
    std::vector<Float2> result(numbers.count());
    const auto& m = lookup.transform;
    for (std::size_t i = 0; i < result.size(); ++i) {
      const double u = numbers.values[2 * i], v = numbers.values[2 * i + 1];
      result[i] = {static_cast<float>(m[0][0] * u + m[0][1] * v + m[0][2]),
                   static_cast<float>(1 - (m[1][0] * u + m[1][1] * v + m[1][2]))};
    }
    return result;
  }

  void readInfluences() {
    for (std::size_t set = 0;; ++set) {
      const std::string number = std::to_string(set);
      const bool has_joints = attributes_.find("JOINTS_" + number).has_value();
      if (has_joints != attributes_.find("WEIGHTS_" + number).has_value()) {
        throw attributes_.error("it has only one of JOINTS_" + number + " and WEIGHTS_" + number,
                                "both or none");
      }
      if (!has_joints) return;
      addInfluences(attribute("JOINTS_" + number, {GltfType::kVector4}),
                    attribute("WEIGHTS_" + number, {GltfType::kVector4}));
    }
  }

  void addInfluences(const GltfNumbers& joints, const GltfNumbers& weights) {
    constexpr std::size_t kSet = 4;
    const std::size_t before = result_.influences, after = before + kSet;
    std::vector<std::uint32_t> all_joints(vertex_count_ * after);
    std::vector<double> all_weights(vertex_count_ * after);
    for (std::size_t i = 0; i < vertex_count_; ++i) {
      for (std::size_t k = 0; k < after; ++k) {
        const bool is_old = k < before;
        const std::size_t old = i * before + k, added = i * kSet + k - before;
        const double joint = is_old ? result_.joints[old] : joints.values[added];
        all_joints[i * after + k] = joint >= 0 && joint <= 0xFFFFFFFE
                                        ? static_cast<std::uint32_t>(joint)
                                        : std::numeric_limits<std::uint32_t>::max();
        all_weights[i * after + k] = is_old ? result_.weights[old] : weights.values[added];
      }
    }
    result_.influences = after;
    result_.joints = std::move(all_joints);
    result_.weights = std::move(all_weights);
  }

  GltfDocument& document_;
  GltfMaterials& materials_;
  GltfCounts& counts_;
  JsonReader primitive_, attributes_;
  const std::vector<double>& morph_weights_;
  std::unique_ptr<GltfDraco> draco_;
  std::size_t vertex_count_ = 0;
  GltfPrimitive result_;
};

template <class Value>
void keepOnly(std::vector<Value>& values, const std::vector<std::uint32_t>& kept, std::size_t width = 1) {
  if (values.empty()) return;
  std::vector<Value> result;
  result.reserve(kept.size() * width);
  for (const std::uint32_t i : kept) {
    for (std::size_t k = 0; k < width; ++k) result.push_back(values[i * width + k]);
  }
  values = std::move(result);
}

// Where primitives share their vertices, each has a copy; so it keeps those that it uses only.
void dropUnusedVertices(GltfPrimitive& primitive) {
  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> place(primitive.positions.size(), kUnused), kept;
  for (const Triangle& triangle : primitive.part.triangles) {
    for (const std::uint32_t corner : triangle) place[corner] = 0;
  }
  for (std::uint32_t i = 0; i < place.size(); ++i) {
    if (place[i] == kUnused) continue;
    place[i] = static_cast<std::uint32_t>(kept.size());
    kept.push_back(i);
  }
  if (kept.size() == place.size()) return;
  for (Triangle& triangle : primitive.part.triangles) {
    for (std::uint32_t& corner : triangle) corner = place[corner];
  }
  keepOnly(primitive.positions, kept);
  keepOnly(primitive.normals, kept);
  keepOnly(primitive.part.texcoords, kept);
  keepOnly(primitive.part.texture_lookups, kept);
  keepOnly(primitive.part.colors, kept);
  keepOnly(primitive.joints, kept, primitive.influences);
  keepOnly(primitive.weights, kept, primitive.influences);
}

// How many primitives of the mesh have the same positions as another one.
bool sharesVertices(const JsonReader& primitives) {
  std::vector<std::uint64_t> positions;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const auto attributes = primitives.at(i).find("attributes");
    const auto position = attributes ? attributes->find("POSITION") : std::nullopt;
    if (position) positions.push_back(position->whole());
  }
  std::sort(positions.begin(), positions.end());
  return std::adjacent_find(positions.begin(), positions.end()) != positions.end();
}

std::vector<double> weightsAt(const JsonReader& object) {
  const auto weights = object.find("weights");
  return weights ? weights->numbers(weights->size()) : std::vector<double>{};
}

}  // namespace

GltfMeshes::GltfMeshes(GltfDocument& document, GltfMaterials& materials)
    : document_(document), materials_(materials), users_(document.count("meshes")) {
  for (std::size_t i = 0; i < document.count("nodes"); ++i) {
    if (const auto mesh = document.item("nodes", i).find("mesh")) ++users_[document.indexAt(*mesh, "meshes")];
  }
}

std::shared_ptr<const GltfMeshes::Primitives> GltfMeshes::get(std::size_t index, const JsonReader& node) {
  const JsonReader mesh = document_.item("meshes", index);
  std::vector<double> weights = weightsAt(node);
  if (weights.empty()) weights = weightsAt(mesh);
  const auto key = std::pair(index, weights);
  if (const auto kept = kept_.find(key); kept != kept_.end()) return kept->second;
  const JsonReader list = mesh.at("primitives");
  const bool shared = sharesVertices(list);
  auto result = std::make_shared<Primitives>();
  for (std::size_t i = 0; i < list.size(); ++i) {
    auto primitive = PrimitiveReader(document_, materials_, counts_, list.at(i), weights).read();
    if (!primitive || primitive->part.triangles.empty()) continue;
    if (shared) dropUnusedVertices(*primitive);
    result->push_back(*std::move(primitive));
  }
  if (users_[index] > 1) kept_.emplace(key, result);
  return result;
}

}  // namespace bakelight::formats
