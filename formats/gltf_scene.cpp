#include "formats/gltf_scene.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/gltf_accessors.h"

namespace bakelight::formats {
namespace {

Double3 triple(const JsonReader& list) {
  const auto values = list.numbers(3);
  return {values[0], values[1], values[2]};
}

// Column-major, as glTF's are.
Transform transformOfMatrix(const double* m) {
  Transform result;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) result.linear[row][column] = m[4 * column + row];
    result.offset[row] = m[12 + row];
  }
  return result;
}

bool isAffine(const double* m) {
  constexpr double kTolerance = 1e-6;  // of writers with single precision
  return std::abs(m[3]) < kTolerance && std::abs(m[7]) < kTolerance && std::abs(m[11]) < kTolerance &&
         std::abs(m[15] - 1) < kTolerance;
}

bool hasDirection(const std::array<double, 4>& q) {
  const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return square > 0 && std::isfinite(square);
}

Transform localTransform(const JsonReader& node) {
  if (const auto matrix = node.find("matrix")) {
    const auto values = matrix->numbers(16);
    if (!isAffine(values.data())) throw matrix->error("its last row is not 0 0 0 1", "an affine transform");
    return transformOfMatrix(values.data());
  }
  Double3 translation = {0, 0, 0}, scale = {1, 1, 1};
  std::array<double, 4> rotation = {0, 0, 0, 1};
  if (const auto value = node.find("translation")) translation = triple(*value);
  if (const auto value = node.find("scale")) scale = triple(*value);
  if (const auto value = node.find("rotation")) {
    const auto q = value->numbers(4);
    rotation = {q[0], q[1], q[2], q[3]};
    if (!hasDirection(rotation)) throw value->error("the quaternion has no length", "a unit quaternion");
  }
  return transformOf(translation, rotation, scale);
}

bool isHidden(const JsonReader& node) {
  const auto visibility = extensionOf(node, "KHR_node_visibility");
  return visibility && !visibility->boolean("visible", true);
}

}  // namespace

GltfScene::GltfScene(GltfDocument& document, std::vector<std::string>& notes) : document_(document) {
  readNodes();
  findWorld();
  collect(rootNodes(notes), notes);
}

void GltfScene::readNodes() {
  const std::size_t count = document_.count("nodes");
  children_.resize(count);
  has_parent_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const JsonReader node = document_.item("nodes", i);
    world_from_node_.push_back(localTransform(node));
    const auto children = node.find("children");
    for (std::size_t k = 0; children && k < children->size(); ++k) {
      const JsonReader reference = children->at(k);
      const std::size_t child = document_.indexAt(reference, "nodes");
      if (has_parent_[child]) {
        throw reference.error("node " + std::to_string(child) + " has another parent already",
                              "one parent a node", "export the file again");
      }
      has_parent_[child] = true;
      children_[i].push_back(child);
    }
  }
}

// No recursion: chains may be longer than the stack.
void GltfScene::findWorld() {
  std::vector<std::size_t> stack;
  for (std::size_t i = 0; i < children_.size(); ++i) {
    if (!has_parent_[i]) stack.push_back(i);
  }
  std::vector<bool> reached(children_.size(), false);
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    reached[node] = true;
    for (const std::size_t child : children_[node]) {
      world_from_node_[child] = world_from_node_[node] * world_from_node_[child];
      stack.push_back(child);
    }
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost == reached.end()) return;
  const auto index = static_cast<std::size_t>(lost - reached.begin());
  throw document_.item("nodes", index).error("the node is below itself", "nodes that form a tree");
}

std::vector<std::size_t> GltfScene::rootNodes(std::vector<std::string>& notes) const {
  std::vector<std::size_t> roots;
  const std::size_t scenes = document_.count("scenes");
  if (scenes == 0) {
    for (std::size_t i = 0; i < children_.size(); ++i) {
      if (!has_parent_[i]) roots.push_back(i);
    }
    return roots;
  }
  const auto named = document_.root().find("scene");
  const std::size_t scene = named ? document_.indexAt(*named, "scenes") : 0;
  if (scenes > 1) {
    notes.push_back("the file has " + std::to_string(scenes) + " scenes: " +
                    (named ? "the default one, " + std::to_string(scene) + "," : "the first") + " was read");
  }
  const auto list = document_.item("scenes", scene).find("nodes");
  for (std::size_t k = 0; list && k < list->size(); ++k) {
    const std::size_t node = document_.indexAt(list->at(k), "nodes");
    if (has_parent_[node] || std::find(roots.begin(), roots.end(), node) != roots.end()) {
      throw list->at(k).error("node " + std::to_string(node) + " is in the scene twice",
                              "nodes without a parent, each once");
    }
    roots.push_back(node);
  }
  return roots;
}

void GltfScene::collect(std::vector<std::size_t> roots, std::vector<std::string>& notes) {
  std::vector<std::size_t> stack(roots.rbegin(), roots.rend());
  std::size_t hidden = 0;
  while (!stack.empty()) {
    const std::size_t node = stack.back();
    stack.pop_back();
    if (isHidden(document_.item("nodes", node))) {
      ++hidden;
      continue;
    }
    nodes_.push_back(node);
    stack.insert(stack.end(), children_[node].rbegin(), children_[node].rend());
  }
  if (hidden > 0) {
    notes.push_back(std::to_string(hidden) + (hidden == 1 ? " node is" : " nodes are") +
                    " invisible (KHR_node_visibility), and left out with all below");
  }
}

std::vector<Transform> instancesOf(GltfDocument& document, const JsonReader& node) {
  const auto instancing = extensionOf(node, "EXT_mesh_gpu_instancing");
  if (!instancing) return {Transform{}};
  const JsonReader attributes = instancing->at("attributes");
  std::optional<std::size_t> count;
  const auto read = [&](const char* name, GltfType type) -> std::optional<GltfNumbers> {
    const auto reference = attributes.find(name);
    if (!reference) return std::nullopt;
    GltfNumbers numbers = readNumbers(document, *reference, {type}, count);
    count = numbers.count();
    return numbers;
  };
  const auto translations = read("TRANSLATION", GltfType::kVector3);
  const auto rotations = read("ROTATION", GltfType::kVector4);
  const auto scales = read("SCALE", GltfType::kVector3);
  if (!count)
    throw attributes.error("it has none of TRANSLATION, ROTATION and SCALE", "at least one of them");
  std::vector<Transform> instances;
  for (std::size_t i = 0; i < *count; ++i) {
    const auto at = [&](const std::optional<GltfNumbers>& numbers, std::size_t c, double otherwise) {
      return numbers ? numbers->values[i * numbers->components + c] : otherwise;
    };
    const std::array<double, 4> rotation = {at(rotations, 0, 0), at(rotations, 1, 0), at(rotations, 2, 0),
                                            at(rotations, 3, 1)};
    if (!hasDirection(rotation)) {
      throw attributes.at("ROTATION")
          .error("quaternion " + std::to_string(i) + " has no length", "unit quaternions");
    }
    instances.push_back(transformOf({at(translations, 0, 0), at(translations, 1, 0), at(translations, 2, 0)},
                                    rotation, {at(scales, 0, 1), at(scales, 1, 1), at(scales, 2, 1)}));
  }
  return instances;
}

GltfSkin::GltfSkin(GltfDocument& document, const JsonReader& skin, const GltfScene& scene) : skin_(skin) {
  const JsonReader joints = skin.at("joints");
  for (std::size_t i = 0; i < joints.size(); ++i) {
    world_from_bind_.push_back(scene.worldFromNode(document.indexAt(joints.at(i), "nodes")));
  }
  const auto reference = skin.find("inverseBindMatrices");
  if (!reference) return;
  const GltfNumbers matrices = readNumbers(document, *reference, {GltfType::kMatrix4});
  if (matrices.count() < joints.size()) {
    throw reference->error("there are " + std::to_string(matrices.count()) + " matrices for " +
                               std::to_string(joints.size()) + " joints",
                           "a matrix for each joint");
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const double* matrix = matrices.values.data() + 16 * i;
    if (!isAffine(matrix)) {
      throw reference->error("the last row of matrix " + std::to_string(i) + " is not 0 0 0 1",
                             "affine transforms");
    }
    world_from_bind_[i] = world_from_bind_[i] * transformOfMatrix(matrix);
  }
}

Transform GltfSkin::blended(const GltfPrimitive& primitive, std::size_t vertex,
                            std::size_t& unweighted) const {
  const std::uint32_t* joints = primitive.joints.data() + vertex * primitive.influences;
  const double* weights = primitive.weights.data() + vertex * primitive.influences;
  double sum = 0;
  for (std::size_t k = 0; k < primitive.influences; ++k) sum += weights[k];
  const bool has_weights = sum > 0 && std::isfinite(sum);
  unweighted += !has_weights;
  Transform result{{}, {}};
  for (std::size_t k = 0; k < (has_weights ? primitive.influences : 1); ++k) {
    const double weight = has_weights ? weights[k] / sum : 1;
    if (weight == 0) continue;
    if (joints[k] >= world_from_bind_.size()) {
      throw skin_.at("joints").error("vertex " + std::to_string(vertex) + " of " + primitive.pointer +
                                         " follows a joint that does not exist",
                                     "joints below " + std::to_string(world_from_bind_.size()));
    }
    const Transform& joint = world_from_bind_[joints[k]];
    for (std::size_t row = 0; row < 3; ++row) {
      result.offset[row] += weight * joint.offset[row];
      for (std::size_t c = 0; c < 3; ++c) result.linear[row][c] += weight * joint.linear[row][c];
    }
  }
  return result;
}

MeshPart GltfSkin::place(const GltfPrimitive& primitive, bool& mirrored, std::size_t& unweighted) const {
  MeshPart part = primitive.part;
  const std::size_t count = primitive.positions.size();
  part.positions.resize(count);
  part.normals.resize(primitive.normals.size());
  std::vector<bool> is_mirrored(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Transform world_from_bind = blended(primitive, i, unweighted);
    part.positions[i] = rounded(world_from_bind.point(primitive.positions[i]));
    const NormalTransform by_normal(world_from_bind);
    is_mirrored[i] = by_normal.determinant < 0;
    if (!part.normals.empty()) part.normals[i] = roundedDirection(by_normal.normal(primitive.normals[i]));
  }
  for (Triangle& triangle : part.triangles) {
    const int turned = is_mirrored[triangle[0]] + is_mirrored[triangle[1]] + is_mirrored[triangle[2]];
    if (turned < 2) continue;
    std::swap(triangle[1], triangle[2]);
    mirrored = true;
  }
  return part;
}

}  // namespace bakelight::formats
