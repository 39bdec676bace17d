#include "formats/meso_mesh.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "formats/error.h"
#include "formats/file.h"
#include "formats/json.h"
#include "formats/materials.h"
#include "formats/mesh_ply.h"
#include "formats/ply_header.h"
#include "formats/ply_materials.h"

namespace bakelight::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "values are copied into the file as they are in memory");

constexpr const char* kSymmetryComment = " meso_mesh symmetry ";
constexpr std::array<const char*, 5> kOwnFloats = {"tangent_x", "tangent_y", "tangent_z", "patch_u",
                                                   "patch_v"};
constexpr const char* kMaterial = "material";
// As for normals (mesh_ply.cpp).
constexpr double kUnitTolerance = 1e-3;
constexpr const char* kRemedy = "make the file again with mesomesh";

bool isSymmetry(int n) {
  return n == 1 || n == 2 || n == 4;
}

std::string headerOf(const MesoMesh& meso) {
  const TriangleMesh& mesh = meso.mesh;
  std::string header = "ply\nformat binary_little_endian 1.0\ncomment";
  header += kSymmetryComment + std::to_string(meso.symmetry) + "\n";
  for (std::size_t m = 0; m < mesh.material_names.size(); ++m)
    header += "comment" + plyMaterialComment(m, mesh.material_names[m]) + "\n";
  header += "element vertex " + std::to_string(mesh.vertexCount()) + "\n";
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"})
    header += std::string("property float ") + name + "\n";
  if (!mesh.colors.empty())
    for (const char* name : {"red", "green", "blue"}) header += std::string("property float ") + name + "\n";
  for (const char* name : kOwnFloats) header += std::string("property float ") + name + "\n";
  header += std::string("property uint ") + kMaterial + "\n";
  header += "element face " + std::to_string(mesh.triangleCount()) + "\n";
  header += "property list uchar uint vertex_indices\n";
  if (!mesh.triangle_materials.empty()) header += std::string("property uint ") + kPlyMaterialIndex + "\n";
  return header + "end_header\n";
}

template <class T>
std::byte* put(std::byte* target, const T& value) {
  std::memcpy(target, &value, sizeof value);
  return target + sizeof value;
}

// Where the properties of a vertex row are that readPly leaves alone.
struct RowLayout {
  std::size_t body = 0, row_size = 0, count = 0;
  std::array<std::size_t, kOwnFloats.size()> floats = {};
  std::size_t material = 0;
};

RowLayout layoutOf(const PlyHeader& header, const std::string& file) {
  const auto missing = [&](const std::string& what) {
    return badInput({file, "header", ""}, "it is no meso-mesh: " + what,
                    "float properties tangent_x … patch_v and a uint property material of vertices", kRemedy);
  };
  if (header.elements.empty() || header.elements.front().name != "vertex")
    throw missing("vertices do not come first");
  const PlyElement& element = header.elements.front();
  RowLayout layout;
  layout.body = header.size_bytes;
  layout.count = element.count;
  std::array<bool, kOwnFloats.size()> has = {};
  bool has_material = false;
  for (const PlyProperty& property : element.properties) {
    for (std::size_t i = 0; i < kOwnFloats.size(); ++i)
      if (property.name == kOwnFloats[i] && property.type == PlyScalar::kFloat32)
        layout.floats[i] = layout.row_size, has[i] = true;
    if (property.name == kMaterial && property.type == PlyScalar::kUint32)
      layout.material = layout.row_size, has_material = true;
    layout.row_size += sizeOf(property.type);
  }
  for (std::size_t i = 0; i < kOwnFloats.size(); ++i)
    if (!has[i]) throw missing(std::string("vertices have no ") + kOwnFloats[i]);
  if (!has_material) throw missing(std::string("vertices have no ") + kMaterial);
  return layout;
}

int symmetryOf(const PlyHeader& header, const std::string& file) {
  const std::string prefix = kSymmetryComment;
  for (const std::string& comment : header.comments) {
    if (!comment.starts_with(prefix)) continue;
    const std::string number = comment.substr(prefix.size());
    if (number == "1" || number == "2" || number == "4") return number[0] - '0';
    throw badInput({file, "header", ""}, "its symmetry is " + number, "1, 2 or 4", kRemedy);
  }
  throw badInput({file, "header", ""}, "it is no meso-mesh: no comment says its symmetry",
                 "comment" + prefix + "1, 2 or 4", kRemedy);
}

class VertexCheck {
 public:
  VertexCheck(const MesoMesh& meso, const std::string& file) : meso_(meso), file_(file) {}

  void check(std::size_t v) const {
    const Float3 &t = meso_.tangents[v], &n = meso_.mesh.normals[v];
    double squared = 0, along = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      squared += static_cast<double>(t[i]) * t[i];
      along += static_cast<double>(t[i]) * n[i];
    }
    if (!(std::abs(std::sqrt(squared) - 1) <= kUnitTolerance))
      throw error(v, "its tangent has no unit length",
                  "length 1 to within 0.001, not " + Json(std::sqrt(squared)).dump());
    if (!(std::abs(along) <= kUnitTolerance))
      throw error(v, "its tangent is not perpendicular to its normal",
                  "a product of 0 to within 0.001, not " + Json(along).dump());
    for (const float x : meso_.patch[v])
      if (!(x >= 0 && x < 1))
        throw error(v, "its place on the exemplar is " + Json(x).dump(), "0 to below 1");
    const std::size_t names = std::max<std::size_t>(1, meso_.mesh.material_names.size());
    if (meso_.materials[v] >= names)
      throw error(v, "material " + std::to_string(meso_.materials[v]) + " does not exist",
                  "an index below " + std::to_string(names));
  }

 private:
  Error error(std::size_t v, const std::string& what, const std::string& expected) const {
    return badInput({file_, "vertex " + std::to_string(v), ""}, what, expected, kRemedy);
  }

  const MesoMesh& meso_;
  const std::string& file_;
};

}  // namespace

void writeMesoMesh(const std::filesystem::path& path, const MesoMesh& meso) {
  const TriangleMesh& mesh = meso.mesh;
  const std::size_t count = mesh.vertexCount();
  if (mesh.normals.size() != count || meso.tangents.size() != count || meso.patch.size() != count ||
      meso.materials.size() != count || (!mesh.colors.empty() && mesh.colors.size() != count))
    throw std::logic_error("a meso-mesh has normals, tangents, places and materials for all vertices");
  if (!mesh.texcoords.empty() || !isSymmetry(meso.symmetry))
    throw std::logic_error("a meso-mesh has no texture coordinates, and a symmetry of 1, 2 or 4");
  requireMaterials(mesh);
  const std::string header = headerOf(meso);
  const bool has_colors = !mesh.colors.empty(), has_materials = !mesh.triangle_materials.empty();
  const std::size_t vertex_size =
      (has_colors ? 4 : 3) * sizeof(Float3) + sizeof(Float2) + sizeof(std::uint32_t);
  const std::size_t face_size = 1 + sizeof(Triangle) + (has_materials ? sizeof(std::uint32_t) : 0);
  Bytes bytes(header.size() + count * vertex_size + mesh.triangleCount() * face_size);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* cursor = bytes.data() + header.size();
  for (std::size_t v = 0; v < count; ++v) {
    cursor = put(put(cursor, mesh.positions[v]), mesh.normals[v]);
    if (has_colors) cursor = put(cursor, mesh.colors[v]);
    cursor = put(put(put(cursor, meso.tangents[v]), meso.patch[v]), meso.materials[v]);
  }
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    cursor = put(put(cursor, std::uint8_t{3}), mesh.triangles[t]);
    if (has_materials) cursor = put(cursor, mesh.triangle_materials[t]);
  }
  writeFileAtomically(path, bytes);
}

MesoMesh readMesoMesh(const std::filesystem::path& path) {
  const std::string file = path.string();
  MesoMesh meso{readPly(path), {}, {}, {}, 1};
  const Bytes bytes = readFile(path);
  const PlyHeader header = readPlyHeader(bytes, file);
  const RowLayout layout = layoutOf(header, file);
  meso.symmetry = symmetryOf(header, file);
  if (meso.mesh.normals.empty())
    throw badInput({file, "header", ""}, "it is no meso-mesh: vertices have no normals", "nx ny nz", kRemedy);
  meso.tangents.resize(layout.count), meso.patch.resize(layout.count), meso.materials.resize(layout.count);
  const VertexCheck check(meso, file);
  for (std::size_t v = 0; v < layout.count; ++v) {
    // readPly has seen that all rows are there.
    const std::byte* row = bytes.data() + layout.body + v * layout.row_size;
    for (std::size_t i = 0; i < layout.floats.size(); ++i)
      std::memcpy(i < 3 ? &meso.tangents[v][i] : &meso.patch[v][i - 3], row + layout.floats[i],
                  sizeof(float));
    std::memcpy(&meso.materials[v], row + layout.material, sizeof(std::uint32_t));
    check.check(v);
  }
  return meso;
}

bool isMesoMesh(const std::filesystem::path& path) {
  try {
    const PlyHeader header = readPlyHeader(readFile(path), path.string());
    return std::any_of(header.comments.begin(), header.comments.end(),
                       [](const std::string& comment) { return comment.starts_with(kSymmetryComment); });
  } catch (const Error&) {
    return false;
  }
}

}  // namespace bakelight::formats
