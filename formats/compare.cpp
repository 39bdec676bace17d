#include "formats/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "formats/field_list.h"
#include "formats/mesh_ply.h"

namespace bakelight::formats {
namespace {

double distanceBetween(const Float3& a, const Float3& b) {
  return std::hypot(static_cast<double>(a[0]) - b[0], static_cast<double>(a[1]) - b[1],
                    static_cast<double>(a[2]) - b[2]);
}

// Largest value, where a NaN stays.
double largest(double a, double b) {
  return std::isnan(a) || a > b ? a : b;
}

template <class Value>
bool agree(Comparison& comparison, const std::string& what, const Value& value, const Value& reference) {
  if (value == reference) return true;
  comparison.mismatches.push_back(what + ": " + Json(value).dump() + ", the reference has " +
                                  Json(reference).dump());
  return false;
}

void append(Comparison& whole, const Comparison& part) {
  whole.compared_values += part.compared_values;
  whole.differences.insert(whole.differences.end(), part.differences.begin(), part.differences.end());
  whole.mismatches.insert(whole.mismatches.end(), part.mismatches.begin(), part.mismatches.end());
}

// --- meshes ---

// Points sorted along x, so that the search for a neighbour can stop early.
class PointSet {
 public:
  explicit PointSet(const std::vector<Float3>& points) : points_(points), order_(points.size()) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(),
                     [&](std::size_t a, std::size_t b) { return points_[a][0] < points_[b][0]; });
  }

  double distanceToNearest(const Float3& query) const {
    double nearest = std::numeric_limits<double>::infinity();
    forNeighbors(query, nearest,
                 [&](std::size_t i) { nearest = std::min(nearest, distanceBetween(points_[i], query)); });
    return nearest;
  }

  // Calls `visit` with the index of each point whose x is within `reach` (which may shrink meanwhile).
  template <class Visit>
  void forNeighbors(const Float3& query, const double& reach, const Visit& visit) const {
    const auto middle = std::lower_bound(order_.begin(), order_.end(), query[0],
                                         [&](std::size_t i, float x) { return points_[i][0] < x; });
    for (auto it = middle; it != order_.end() && points_[*it][0] - query[0] <= reach; ++it) visit(*it);
    for (auto it = middle; it != order_.begin() && query[0] - points_[*std::prev(it)][0] <= reach; --it)
      visit(*std::prev(it));
  }

 private:
  const std::vector<Float3>& points_;
  std::vector<std::size_t> order_;
};

double farthestFromSet(const std::vector<Float3>& points, const PointSet& set) {
  double farthest = 0;
  for (const Float3& point : points) farthest = largest(set.distanceToNearest(point), farthest);
  return farthest;
}

double hausdorffDistance(const std::vector<Float3>& a, const std::vector<Float3>& b) {
  return largest(farthestFromSet(a, PointSet(b)), farthestFromSet(b, PointSet(a)));
}

// Of all triangles, or of those of one material.
std::vector<Float3> centroids(const TriangleMesh& mesh, std::optional<std::size_t> material = std::nullopt) {
  std::vector<Float3> result;
  for (std::size_t i = 0; i < mesh.triangleCount(); ++i) {
    if (material && mesh.triangle_materials[i] != *material) continue;
    const Triangle& t = mesh.triangles[i];
    Float3 centroid{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      centroid[axis] =
          (mesh.positions[t[0]][axis] + mesh.positions[t[1]][axis] + mesh.positions[t[2]][axis]) / 3;
    result.push_back(centroid);
  }
  return result;
}

double boxDiagonal(const std::vector<Float3>& points) {
  Float3 low = points.front(), high = points.front();
  for (const Float3& point : points)
    for (std::size_t axis = 0; axis < 3; ++axis)
      low[axis] = std::min(low[axis], point[axis]), high[axis] = std::max(high[axis], point[axis]);
  return distanceBetween(low, high);
}

// Vertices at a crease share their position, so of all vertices that are as near as the nearest one (give or
// take `slack`), the one with the likest normal counts.
double normalDifference(const TriangleMesh& mesh, const TriangleMesh& reference, double slack) {
  const PointSet set(reference.positions);
  double largest_difference = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Float3& position = mesh.positions[v];
    const double reach = set.distanceToNearest(position) + slack;
    double likest = std::numeric_limits<double>::infinity();
    set.forNeighbors(position, reach, [&](std::size_t i) {
      if (distanceBetween(reference.positions[i], position) <= reach)
        likest = std::min(likest, distanceBetween(reference.normals[i], mesh.normals[v]));
    });
    largest_difference = largest(likest, largest_difference);
  }
  return largest_difference;
}

// --- lists of values ---

struct ValueDifference {
  double maximum = 0, sum_of_squares = 0, reference_sum_of_squares = 0;

  void add(double value, double reference) {
    // Equal infinities are equal.
    const double difference = value == reference ? 0 : std::abs(value - reference);
    maximum = largest(difference, maximum);
    sum_of_squares += difference * difference;
    reference_sum_of_squares += reference * reference;
  }
  double relativeNorm() const {
    return sum_of_squares == 0 ? 0 : std::sqrt(sum_of_squares) / std::sqrt(reference_sum_of_squares);
  }
};

void addValues(Comparison& comparison, const std::string& name, const ValueDifference& difference,
               const CompareLimits& limits) {
  comparison.differences.push_back({name + ", relative norm", difference.relativeNorm(), limits.relative});
  comparison.differences.push_back({name + ", maximum", difference.maximum, limits.maximum});
}

// Of vertex by vertex; nothing if there is none.
template <class Value>
void addAttribute(Comparison& comparison, const std::string& name, const std::vector<Value>& values,
                  const std::vector<Value>& reference, const CompareLimits& limits) {
  if (values.empty()) return;
  ValueDifference difference;
  for (std::size_t v = 0; v < values.size(); ++v)
    for (std::size_t i = 0; i < values[v].size(); ++i) difference.add(values[v][i], reference[v][i]);
  comparison.differences.push_back({name + ", maximum", difference.maximum, limits.maximum});
}

template <class T>
ValueDifference differenceOf(const Tensor& tensor, const Tensor& reference) {
  const auto values = tensor.as<T>(), reference_values = reference.as<T>();
  ValueDifference difference;
  for (std::size_t i = 0; i < values.size(); ++i)
    difference.add(static_cast<double>(values[i]), static_cast<double>(reference_values[i]));
  return difference;
}

ValueDifference tensorDifference(const Tensor& tensor, const Tensor& reference) {
  switch (tensor.type) {
    case ElementType::kFloat32:
      return differenceOf<float>(tensor, reference);
    case ElementType::kFloat64:
      return differenceOf<double>(tensor, reference);
    case ElementType::kUint8:
      return differenceOf<std::uint8_t>(tensor, reference);
    case ElementType::kFloat16:  // by their codes
    case ElementType::kUint16:
      return differenceOf<std::uint16_t>(tensor, reference);
    case ElementType::kUint32:
      return differenceOf<std::uint32_t>(tensor, reference);
    case ElementType::kInt32:
      return differenceOf<std::int32_t>(tensor, reference);
    case ElementType::kInt64:
      return differenceOf<std::int64_t>(tensor, reference);
  }
  throw std::logic_error("an element type without a comparison");
}

bool isIgnored(const CompareLimits& limits, const std::string& key) {
  return std::find(limits.ignored_keys.begin(), limits.ignored_keys.end(), key) != limits.ignored_keys.end();
}

template <class Map>
std::vector<std::string> keysOf(const Map& map) {
  std::vector<std::string> keys;
  keys.reserve(map.size());
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

// --- JSON ---

class JsonComparer {
 public:
  JsonComparer(const CompareLimits& limits, Comparison& comparison)
      : limits_(limits), comparison_(comparison) {}

  void compare(const Json& json, const Json& reference, const std::string& pointer) {
    if (json.is_object() && reference.is_object()) {
      compareObjects(json, reference, pointer);
    } else if (json.is_array() && reference.is_array()) {
      if (!agree(comparison_, pointer + ", elements", json.size(), reference.size())) return;
      for (std::size_t i = 0; i < json.size(); ++i)
        compare(json[i], reference[i], pointer + "/" + std::to_string(i));
    } else {
      compareValues(json, reference, pointer);
    }
  }

 private:
  void compareObjects(const Json& json, const Json& reference, const std::string& pointer) {
    for (const auto& [key, value] : json.items())
      if (!isIgnored(limits_, key) && !reference.contains(key))
        comparison_.mismatches.push_back(childPointer(pointer, key) + " is not in the reference");
    for (const auto& [key, value] : reference.items()) {
      if (isIgnored(limits_, key)) continue;
      if (json.contains(key))
        compare(json[key], value, childPointer(pointer, key));
      else
        comparison_.mismatches.push_back(childPointer(pointer, key) + " is missing");
    }
  }

  void compareValues(const Json& json, const Json& reference, const std::string& pointer) {
    ++comparison_.compared_values;
    const bool real =
        json.is_number() && reference.is_number() && (json.is_number_float() || reference.is_number_float());
    if (!real) {
      agree(comparison_, pointer, json, reference);
      return;
    }
    const auto a = json.get<double>(), b = reference.get<double>();
    const double relative = a == b ? 0 : std::abs(a - b) / std::max(std::abs(a), std::abs(b));
    comparison_.differences.push_back({pointer + ", relative", relative, limits_.relative});
  }

  const CompareLimits& limits_;
  Comparison& comparison_;
};

// --- packs ---

void compareLists(Comparison& comparison, const std::string& name, const std::vector<float>& values,
                  const std::vector<float>& reference, const CompareLimits& limits) {
  if (!agree(comparison, name + " values", values.size(), reference.size()) || values.empty()) return;
  ValueDifference difference;
  for (std::size_t i = 0; i < values.size(); ++i) difference.add(values[i], reference[i]);
  comparison.compared_values += values.size();
  addValues(comparison, name, difference, limits);
}

void compareTables(Comparison& comparison, const std::string& name, const EncodedTable& table,
                   const EncodedTable& reference, const CompareLimits& limits) {
  bool same_shape = agree(comparison, name + ", precision", std::string(nameOf(table.precision)),
                          std::string(nameOf(reference.precision)));
  same_shape &= agree(comparison, name + ", columns", table.columns, reference.columns);
  if (same_shape) compareLists(comparison, name, table.decode(), reference.decode(), limits);
}

template <class Vector>
std::vector<float> flattened(const std::vector<Vector>& vectors) {
  std::vector<float> values;
  for (const Vector& vector : vectors) values.insert(values.end(), vector.begin(), vector.end());
  return values;
}

std::size_t firstDifference(const SharedBytes& a, const SharedBytes& b) {
  return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin()).first - a.begin());
}

// Fields of the same name; whoever has one that the other lacks differs.
void compareParts(Comparison& comparison, const std::string& name, const PackPart& part,
                  const PackPart& reference, const CompareLimits& limits) {
  if (!agree(comparison, name + " kind", std::string(part.kind()), std::string(reference.kind()))) return;
  const std::vector<FieldValue> fields = fieldsOf(part), expected = fieldsOf(reference);
  const auto namesOfFields = [](const std::vector<FieldValue>& list) {
    std::vector<std::string> names;
    for (const FieldValue& field : list) names.push_back(field.name);
    return names;
  };
  if (!agree(comparison, name + " fields", namesOfFields(fields), namesOfFields(expected))) return;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string label = name + " " + fields[i].name;
    if (fields[i].isPlain()) {
      agree(comparison, label, fields[i].plain, expected[i].plain);
    } else if (fields[i].table != nullptr) {
      compareTables(comparison, label, *fields[i].table, *expected[i].table, limits);
    } else if (fields[i].integers != nullptr) {
      const SharedBytes &mine = fields[i].integers->data, &theirs = expected[i].integers->data;
      if (agree(comparison, label + ", bytes", mine.size(), theirs.size()))
        agree(comparison, label + ", first byte that differs", firstDifference(mine, theirs), mine.size());
    } else {
      compareLists(comparison, label, fields[i].values, expected[i].values, limits);
    }
  }
}

void compareMaterials(Comparison& comparison, const TriangleMesh& mesh, const TriangleMesh& reference,
                      const CompareLimits& limits) {
  if (!agree(comparison, "materials", mesh.material_names.size(), reference.material_names.size())) return;
  const double diagonal = std::max(boxDiagonal(reference.positions), std::numeric_limits<double>::min());
  for (std::size_t m = 0; m < mesh.material_names.size(); ++m) {
    const std::string name = "material " + std::to_string(m);
    agree(comparison, name + ", name", mesh.material_names[m], reference.material_names[m]);
    const std::vector<Float3> places = centroids(mesh, m), expected = centroids(reference, m);
    if (agree(comparison, name + ", triangles", places.size(), expected.size()) && !places.empty())
      comparison.differences.push_back(
          {name + ", distance", hausdorffDistance(places, expected) / diagonal, limits.distance});
  }
}

std::vector<std::string> sectionNames(const std::filesystem::path& file) {
  std::vector<std::string> names;
  for (const PackSection& section : packSections(readFile(file), file.string()))
    names.push_back(section.name);
  return names;
}

}  // namespace

bool Comparison::passes() const {
  return compared_values > 0 && mismatches.empty() &&
         std::all_of(differences.begin(), differences.end(), [](const Difference& d) { return d.passes(); });
}

Comparison compareMeshes(const TriangleMesh& mesh, const TriangleMesh& reference,
                         const CompareLimits& limits) {
  Comparison comparison;
  bool same_shape = agree(comparison, "vertices", mesh.vertexCount(), reference.vertexCount());
  same_shape &= agree(comparison, "triangles", mesh.triangleCount(), reference.triangleCount());
  same_shape &= agree(comparison, "normals", mesh.normals.size(), reference.normals.size());
  same_shape &= agree(comparison, "texcoords", mesh.texcoords.size(), reference.texcoords.size());
  same_shape &= agree(comparison, "colors", mesh.colors.size(), reference.colors.size());
  if (!same_shape || mesh.positions.empty()) return comparison;

  const double diagonal = std::max(boxDiagonal(reference.positions), std::numeric_limits<double>::min());
  comparison.compared_values = mesh.vertexCount() + mesh.triangleCount();
  comparison.differences.push_back({"vertices, distance",
                                    hausdorffDistance(mesh.positions, reference.positions) / diagonal,
                                    limits.distance});
  comparison.differences.push_back({"triangles, distance",
                                    hausdorffDistance(centroids(mesh), centroids(reference)) / diagonal,
                                    limits.distance});
  if (!mesh.normals.empty()) {
    const double slack = limits.distance * diagonal;
    comparison.differences.push_back(
        {"normals, difference",
         largest(normalDifference(mesh, reference, slack), normalDifference(reference, mesh, slack)),
         limits.normal});
  }
  addAttribute(comparison, "texcoords", mesh.texcoords, reference.texcoords, limits);
  addAttribute(comparison, "colors", mesh.colors, reference.colors, limits);
  compareMaterials(comparison, mesh, reference, limits);
  return comparison;
}

Comparison compareMesoMeshes(const MesoMesh& meso, const MesoMesh& reference, const CompareLimits& limits) {
  Comparison comparison = compareMeshes(meso.mesh, reference.mesh, limits);
  agree(comparison, "symmetry", meso.symmetry, reference.symmetry);
  if (meso.tangents.size() != reference.tangents.size()) return comparison;
  addAttribute(comparison, "tangents", meso.tangents, reference.tangents, limits);
  addAttribute(comparison, "places on the exemplar", meso.patch, reference.patch, limits);
  for (std::size_t v = 0; v < meso.materials.size(); ++v)
    if (!agree(comparison, "vertex " + std::to_string(v) + ", material", meso.materials[v],
               reference.materials[v]))
      break;
  return comparison;
}

namespace {

// Of images with values; counts these as compared.
template <class AnyImage>
bool haveOneShape(Comparison& comparison, const AnyImage& image, const AnyImage& reference) {
  bool same_shape = agree(comparison, "width", image.width, reference.width);
  same_shape &= agree(comparison, "height", image.height, reference.height);
  same_shape &= agree(comparison, "channels", image.channel_names, reference.channel_names);
  if (same_shape) comparison.compared_values = image.values.size();
  return same_shape && !image.values.empty();
}

}  // namespace

Comparison compareImages(const Image& image, const Image& reference, const CompareLimits& limits) {
  Comparison comparison;
  if (!haveOneShape(comparison, image, reference)) return comparison;
  std::vector<ValueDifference> channels(image.channelCount());
  for (std::size_t i = 0; i < image.values.size(); ++i)
    channels[i % channels.size()].add(image.values[i], reference.values[i]);
  const auto texels = static_cast<double>(image.width) * image.height;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::string name = "channel " + image.channel_names[c];
    comparison.differences.push_back({name + ", maximum", channels[c].maximum, limits.maximum});
    comparison.differences.push_back(
        {name + ", rms", std::sqrt(channels[c].sum_of_squares / texels), limits.rms});
  }
  return comparison;
}

Comparison compareIndices(const IndexImage& image, const IndexImage& reference, const CompareLimits& limits) {
  Comparison comparison;
  if (!haveOneShape(comparison, image, reference)) return comparison;
  std::vector<std::size_t> others(image.channelCount(), 0);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    others[i % others.size()] += image.values[i] != reference.values[i] ? 1 : 0;
  const auto texels = static_cast<double>(image.width) * image.height;
  for (std::size_t c = 0; c < others.size(); ++c)
    comparison.differences.push_back({"channel " + image.channel_names[c] + ", share of others",
                                      static_cast<double>(others[c]) / texels, limits.share});
  return comparison;
}

Comparison compareTensors(const TensorFile& tensors, const TensorFile& reference,
                          const CompareLimits& limits) {
  Comparison comparison;
  agree(comparison, "tensors", keysOf(tensors.tensors), keysOf(reference.tensors));
  for (const auto& [name, tensor] : tensors.tensors) {
    const auto entry = reference.tensors.find(name);
    if (entry == reference.tensors.end()) continue;
    const std::string label = "tensor " + name;
    bool same_shape = agree(comparison, label + ", type", std::string(safetensorsName(tensor.type)),
                            std::string(safetensorsName(entry->second.type)));
    same_shape &= agree(comparison, label + ", shape", tensor.shape, entry->second.shape);
    if (!same_shape) continue;
    comparison.compared_values += tensor.elementCount();
    addValues(comparison, label, tensorDifference(tensor, entry->second), limits);
  }

  auto metadata = tensors.metadata, reference_metadata = reference.metadata;
  for (const std::string& key : limits.ignored_keys) metadata.erase(key), reference_metadata.erase(key);
  agree(comparison, "metadata", metadata, reference_metadata);
  return comparison;
}

Comparison compareRadianceTransferTextures(std::span<const RadianceTransferTexture> textures,
                                           std::span<const RadianceTransferTexture> reference,
                                           const CompareLimits& limits) {
  const auto layoutOf = [](std::span<const RadianceTransferTexture> all) {
    Json layout = Json::array();
    for (const RadianceTransferTexture& each : all)
      layout.push_back({each.material, each.order, each.views, each.width, each.height, each.heights.size()});
    return layout;
  };
  Comparison comparison;
  if (!agree(comparison, "textures (material, order, views, width, height, heights)", layoutOf(textures),
             layoutOf(reference)))
    return comparison;
  for (std::size_t t = 0; t < textures.size(); ++t) {
    ValueDifference difference;
    for (std::size_t i = 0; i < textures[t].values.size(); ++i)
      difference.add(textures[t].values[i], reference[t].values[i]);
    comparison.compared_values += textures[t].values.size();
    addValues(comparison, "texture \"" + textures[t].material + "\"", difference, limits);
    if (textures[t].heights.empty()) continue;
    ValueDifference of_heights;
    for (std::size_t i = 0; i < textures[t].heights.size(); ++i)
      of_heights.add(textures[t].heights[i], reference[t].heights[i]);
    comparison.compared_values += textures[t].heights.size();
    addValues(comparison, "heights of texture \"" + textures[t].material + "\"", of_heights, limits);
  }
  return comparison;
}

namespace {

bool haveOneSampling(Comparison& comparison, const Btf& btf, const Btf& reference) {
  const BtfInfo &info = btf.info(), &expected = reference.info();
  bool same = agree(comparison, "width", info.width, expected.width);
  same &= agree(comparison, "height", info.height, expected.height);
  same &= agree(comparison, "cosine inside", info.cosine_inside, expected.cosine_inside);
  constexpr double kSame_rad = 1e-5;
  for (const auto& [what, list] :
       {std::pair("view", &BtfInfo::views), std::pair("light", &BtfInfo::lights)}) {
    const std::vector<BtfDirection>&directions = info.*list, &others = expected.*list;
    if (!agree(comparison, std::string(what) + "s", directions.size(), others.size())) return false;
    for (std::size_t i = 0; i < directions.size() && same; ++i)
      if (std::abs(directions[i].polar_rad - others[i].polar_rad) > kSame_rad ||
          std::abs(directions[i].azimuth_rad - others[i].azimuth_rad) > kSame_rad)
        same = agree(comparison, what + (" " + std::to_string(i)) + ", polar angle and azimuth",
                     std::pair(directions[i].polar_rad, directions[i].azimuth_rad),
                     std::pair(others[i].polar_rad, others[i].azimuth_rad));
  }
  return same;
}

}  // namespace

Comparison compareBtfs(const Btf& btf, const Btf& reference, const CompareLimits& limits) {
  constexpr std::size_t kBlock = 1024;  // texels
  Comparison comparison;
  if (!haveOneSampling(comparison, btf, reference)) return comparison;
  ValueDifference difference;
  const std::size_t texels = btf.texelCount();
  for (int v = 0; v < static_cast<int>(btf.info().views.size()); ++v) {
    const std::vector<int> lights = btf.lightsOf(v);
    if (!agree(comparison, "view " + std::to_string(v) + ", lights", lights, reference.lightsOf(v)))
      return comparison;
    const auto view = btf.view(v), expected = reference.view(v);
    for (std::size_t first = 0; first < texels; first += kBlock) {
      const std::size_t count = std::min(kBlock, texels - first);
      std::vector<float> values(3 * lights.size() * count), expected_values(values.size());
      view->decode(lights, {first, count}, values);
      expected->decode(lights, {first, count}, expected_values);
      for (std::size_t i = 0; i < values.size(); ++i) difference.add(values[i], expected_values[i]);
      comparison.compared_values += values.size();
    }
  }
  addValues(comparison, "values", difference, limits);
  return comparison;
}

Comparison compareJson(const Json& json, const Json& reference, const CompareLimits& limits) {
  Comparison comparison;
  JsonComparer(limits, comparison).compare(json, reference, "");
  return comparison;
}

Comparison comparePacks(const Pack& pack, const Pack& reference, const CompareLimits& limits) {
  Comparison comparison = compareMeshes(pack.mesh, reference.mesh, limits);
  agree(comparison, "name", pack.name, reference.name);
  compareLists(comparison, "colors", flattened(pack.colors), flattened(reference.colors), limits);
  compareParts(comparison, "transfer", pack.transfer, reference.transfer, limits);
  if (!agree(comparison, "materials", pack.appearances.size(), reference.appearances.size()))
    return comparison;
  for (std::size_t i = 0; i < pack.appearances.size(); ++i) {
    const Appearance &appearance = pack.appearances[i], &expected = reference.appearances[i];
    const std::string name = "material " + std::to_string(i);
    agree(comparison, name + " name", appearance.material, expected.material);
    agree(comparison, name + " base color", appearance.base_color, expected.base_color);
    compareParts(comparison, name, appearance.reflection, expected.reflection, limits);
  }
  if (agree(comparison, "neighborhood", pack.neighborhood.has_value(), reference.neighborhood.has_value()) &&
      pack.neighborhood)
    compareParts(comparison, "neighborhood", *pack.neighborhood, *reference.neighborhood, limits);
  return comparison;
}

const std::vector<std::string>& comparedKinds() {
  static const std::vector<std::string> kinds = {"mesh", "meso_mesh", "image", "id_map", "rtt",
                                                 "btf",  "tensors",   "json",  "pack"};
  return kinds;
}

Comparison compareFiles(const std::string& kind, const std::filesystem::path& file,
                        const std::filesystem::path& reference, const CompareLimits& limits) {
  if (kind == "mesh") return compareMeshes(readPly(file), readPly(reference), limits);
  if (kind == "meso_mesh") return compareMesoMeshes(readMesoMesh(file), readMesoMesh(reference), limits);
  if (kind == "image") return compareImages(readImage(file), readImage(reference), limits);
  if (kind == "id_map") {
    const std::vector<std::string> channels = exrChannels(reference);
    return compareIndices(readIndexExr(file, channels), readIndexExr(reference, channels), limits);
  }
  if (kind == "rtt")
    return compareRadianceTransferTextures(readRadianceTransferTextures(file),
                                           readRadianceTransferTextures(reference), limits);
  if (kind == "btf") return compareBtfs(*openBtf(file), *openBtf(reference), limits);
  if (kind == "tensors") return compareTensors(readSafetensors(file), readSafetensors(reference), limits);
  if (kind == "json") return compareJson(readJson(file), readJson(reference), limits);
  if (kind != "pack") throw std::invalid_argument("there is no comparison for files of kind " + kind);
  Comparison comparison;
  agree(comparison, "sections", sectionNames(file), sectionNames(reference));
  append(comparison, comparePacks(readPack(file), readPack(reference), limits));
  return comparison;
}

}  // namespace bakelight::formats
