#include "formats/assimp_orientation.h"

#include <assimp/scene.h>
#include <fmt/format.h>
#include <array>
#include <cmath>
#include <optional>

namespace bakelight::formats {
namespace {

std::string axisName(int axis, int sign) {
  return std::string(sign < 0 ? "−" : "+") + "XYZ"[axis];
}

std::string numberText(double value) {
  return fmt::format("{:g}", value);
}

struct Axis {
  int axis = 0, sign = 1;
};

std::optional<Axis> axisAt(const aiMetadata& metadata, const std::string& name) {
  std::int32_t axis = 0, sign = 1;
  if (!metadata.Get(name, axis) || axis < 0 || axis > 2) return std::nullopt;
  if (!metadata.Get(name + "Sign", sign)) sign = 1;
  return Axis{axis, sign < 0 ? -1 : 1};
}

// FBX names the axes that point to the right, up, and to the viewer; assimp hands them on and leaves the
// scene as it is.
Transform uprightFromFbx(const aiMetadata& metadata, std::vector<std::string>& notes) {
  const auto up = axisAt(metadata, "UpAxis");
  if (!up) return {};
  const auto front = axisAt(metadata, "FrontAxis"), right = axisAt(metadata, "CoordAxis");
  Transform result;
  const bool is_whole =
      front && right && up->axis != front->axis && up->axis != right->axis && front->axis != right->axis;
  // Where the other two make no sense, up is all that counts: the quarter turn that brings it there.
  const std::array<Axis, 3> axes =
      is_whole ? std::array<Axis, 3>{*right, *up, *front}
               : std::array<Axis, 3>{Axis{up->axis == 0 ? 1 : 0, up->axis == 0 ? -up->sign : 1}, *up,
                                     Axis{up->axis == 2 ? 1 : 2, up->axis == 2 ? -up->sign : 1}};
  for (std::size_t row = 0; row < 3; ++row) {
    result.linear[row] = {0, 0, 0};
    result.linear[row][static_cast<std::size_t>(axes[row].axis)] = axes[row].sign;
  }
  if (!result.isIdentity()) {
    notes.push_back("the file has " + axisName(up->axis, up->sign) + " up" +
                    (up->axis == 1 && up->sign > 0 ? ", but looks another way" : "") + ": turned to +Y up");
  }
  return result;
}

void noteUnitOfFbx(const aiMetadata& metadata, std::vector<std::string>& notes) {
  double centimeters = 0;
  float single = 0;
  if (!metadata.Get("UnitScaleFactor", centimeters) && metadata.Get("UnitScaleFactor", single))
    centimeters = single;
  if (centimeters > 0 && centimeters != 100) {
    notes.push_back("lengths are in the file's own unit, of " + numberText(centimeters) + " cm");
  }
}

double scaleOf(const aiMatrix4x4& m) {
  return std::sqrt(double{m.a1} * m.a1 + double{m.b1} * m.b1 + double{m.c1} * m.c1);
}

// assimp turns and scales COLLADA by the root node: what it did is read back from there.
void noteRootOfCollada(const aiScene& scene, std::vector<std::string>& notes) {
  const aiMatrix4x4& m = scene.mRootNode->mTransformation;
  const double unit = scaleOf(m);
  if (m.b3 > 0) notes.emplace_back("the file has +Z up: turned to +Y up");
  if (m.b1 > 0) notes.emplace_back("the file has +X up: turned to +Y up");
  if (std::abs(unit - 1) > 1e-6) {
    notes.push_back("lengths are in metres: the file's unit has " + numberText(unit));
  }
}

// So, too, with 3DS: (x, y, z) becomes (x, z, −y), divided by the master scale.
void noteRootOf3ds(const aiScene& scene, std::vector<std::string>& notes) {
  notes.emplace_back("3DS files have +Z up: turned to +Y up");
  const double scale = scaleOf(scene.mRootNode->mTransformation);
  if (std::abs(scale - 1) > 1e-6) {
    notes.push_back("lengths are multiplied by " + numberText(scale) + ", as the file has a master scale");
  }
}

}  // namespace

Transform uprightFromScene(const aiScene& scene, const std::string& ending, std::vector<std::string>& notes) {
  if (ending == ".fbx" && scene.mMetaData != nullptr) {
    noteUnitOfFbx(*scene.mMetaData, notes);
    return uprightFromFbx(*scene.mMetaData, notes);
  }
  if (ending == ".dae") noteRootOfCollada(scene, notes);
  if (ending == ".3ds") noteRootOf3ds(scene, notes);
  return {};
}

}  // namespace bakelight::formats
