#include "formats/light_rig_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/color_picture.h"
#include "formats/error.h"
#include "formats/json_members.h"
#include "formats/mesh_import.h"

namespace bakelight::formats {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestRadiance = 1e12;
constexpr double kLargestLength = 1e9;
constexpr double kSmallest = 1e-6;  // where a width, an angle or a period has to be more than nothing
constexpr double kAutomaticWindow = -1;

using Range = JsonMembers::Range;
constexpr Range kRadiance = {0, kLargestRadiance}, kPosition = {-kLargestLength, kLargestLength},
                kExtent = {kSmallest, kLargestLength}, kTurn = {-360, 360};

bool isZero(const Float3& v) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

class Members : public JsonMembers {
 public:
  using JsonMembers::JsonMembers;

  void readDirection(const std::string& name, Float3& value) {
    read(name, value, kPosition);
    if (isZero(value)) throw badInput(placeOf(name), "it has no direction", "three numbers, not all zero");
  }
  // An existing file; its name is relative to the folder of this one.
  fs::path readPath(const std::string& name, const std::string& expected) {
    return readFile(name, expected, "write its path relative to the folder of the light rig");
  }
};

EnvironmentLight readEnvironment(Members& members) {
  EnvironmentLight light;
  light.path = members.readPath("image", "an HDR image: lat-long, or a strip of six cube faces");
  ColorPicture picture = readColorPicture(light.path, PictureUse::kLight);
  light.image = std::move(picture.image);
  light.notes = std::move(picture.notes);
  const int width = light.image.width, height = light.image.height;
  if (width != 2 * height && width != 6 * height && height != 6 * width)
    throw badInput(
        members.placeOf("image"),
        light.path.string() + " is " + std::to_string(width) + " × " + std::to_string(height) + " pixels",
        "2:1 (lat-long), 6:1 or 1:6 (cube faces +X −X +Y −Y +Z −Z)");
  members.read("yaw_deg", light.yaw_deg, kTurn);
  members.read("intensity", light.intensity, kRadiance);
  return light;
}

DiskLight readDisk(Members& members) {
  DiskLight light;
  members.readDirection("direction", light.direction);
  members.read("half_angle_deg", light.half_angle_deg, {kSmallest, 180});
  members.read("radiance", light.radiance, kRadiance);
  return light;
}

bool areOpposite(const Float3& a, const Float3& b) {
  double dot = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    dot += static_cast<double>(a[i]) * b[i];
    aa += static_cast<double>(a[i]) * a[i];
    bb += static_cast<double>(b[i]) * b[i];
  }
  return dot < -(1 - 1e-12) * std::sqrt(aa * bb);
}

PolygonLight readPolygon(Members& members) {
  PolygonLight light;
  const std::string expected = "a list of at least 3 positions [x, y, z], in order around the polygon";
  const Json& list = members.require("vertices", expected);
  const ErrorPlace place = members.placeOf("vertices");
  if (!list.is_array() || list.size() < 3) throw badInput(place, "it is not such a list", expected);
  const auto placeOfVertex = [&](std::size_t i) {
    return ErrorPlace{place.file, "", childPointer(place.pointer, std::to_string(i))};
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    light.vertices.push_back(Members::triple(list[i], "vertices", kPosition, placeOfVertex(i)));
    if (isZero(light.vertices.back()))
      throw badInput(placeOfVertex(i), "it lies at the object itself", "a position as seen from the object");
  }
  for (std::size_t i = 0; i < list.size(); ++i)
    if (areOpposite(light.vertices[i], light.vertices[(i + 1) % list.size()]))
      throw badInput(placeOfVertex(i), "this vertex and the next lie in opposite directions",
                     "a polygon that spans less than a hemisphere", "put a vertex between them");
  members.read("radiance", light.radiance, kRadiance);
  return light;
}

DirectionalLight readDirectional(Members& members) {
  DirectionalLight light;
  members.readDirection("direction", light.direction);
  members.read("irradiance", light.irradiance, kRadiance);
  return light;
}

SkyLight readSky(Members& members) {
  SkyLight light;
  members.read("turbidity", light.turbidity, {1.7, 10});
  members.read("sun_elevation_deg", light.sun_elevation_deg, {-90, 90});
  members.read("sun_azimuth_deg", light.sun_azimuth_deg, kTurn);
  members.read("sun", light.sun);
  members.read("ground_albedo", light.ground_albedo, {0, 1});
  members.read("intensity", light.intensity, kRadiance);
  return light;
}

DistantLight readDistant(const Json& json, const std::string& file, const std::string& pointer) {
  Members members(json, file, pointer);
  const std::size_t type =
      members.readChoice("type", {"environment", "disk", "polygon", "directional", "sky"});
  DistantLight light = type == 0   ? DistantLight(readEnvironment(members))
                       : type == 1 ? DistantLight(readDisk(members))
                       : type == 2 ? DistantLight(readPolygon(members))
                       : type == 3 ? DistantLight(readDirectional(members))
                                   : DistantLight(readSky(members));
  members.refuseOthers();
  return light;
}

Motion readMotion(const Json& json, const std::string& file, const std::string& pointer) {
  Members members(json, file, pointer);
  Motion motion;
  const std::size_t kind = members.readChoice("kind", {"still", "orbit", "shuttle"});
  if (kind == 1) {
    motion.kind = Motion::Kind::kOrbit;
    members.readDirection("axis", motion.axis);
    members.read("center", motion.center, kPosition);
  } else if (kind == 2) {
    motion.kind = Motion::Kind::kShuttle;
    members.require("to", "the position at which it turns round");
    members.read("to", motion.to, kPosition);
  }
  if (kind != 0) members.read("period_s", motion.period_s, {1e-3, 1e6});
  members.refuseOthers();
  return motion;
}

Emitter readEmitter(const Json& json, const std::string& file, const std::string& pointer) {
  Members members(json, file, pointer);
  Emitter emitter;
  const std::size_t shape = members.readChoice("shape", {"quad", "sphere", "mesh"});
  members.read("position", emitter.position, kPosition);
  members.read("radiance", emitter.radiance, kRadiance);
  if (shape == 0) {
    emitter.shape = Emitter::Shape::kQuad;
    members.readDirection("normal", emitter.normal);
    members.read("width", emitter.width, kExtent);
    members.read("height", emitter.height, kExtent);
  } else if (shape == 1) {
    emitter.shape = Emitter::Shape::kSphere;
    members.read("radius", emitter.radius, kExtent);
  } else {
    emitter.shape = Emitter::Shape::kMesh;
    emitter.path = members.readPath("mesh", "a mesh file, for example .obj or .ply");
    emitter.mesh = importMesh(emitter.path).mesh;
    members.read("scale", emitter.scale, kExtent);
  }
  if (const Json* motion = members.find("motion"))
    emitter.motion = readMotion(*motion, file, members.placeOf("motion").pointer);
  members.refuseOthers();
  return emitter;
}

double readWindowing(Members& members) {
  const Json* json = members.find("windowing");
  if (json == nullptr) return 0;
  if (*json == "auto") return kAutomaticWindow;
  if (json->is_string())
    throw badInput(members.placeOf("windowing"), json->dump() + " is not a strength",
                   "\"auto\", or a number of 0 or more", "\"auto\"");
  return Members::real(*json, "windowing", {0, 1e9}, members.placeOf("windowing"));
}

// Calls read(element, pointer) for each element of the list `name`, which may be missing.
template <class Read>
void readList(Members& members, const std::string& name, const Read& read) {
  const Json* list = members.find(name);
  if (list == nullptr) return;
  const ErrorPlace place = members.placeOf(name);
  if (!list->is_array()) throw badInput(place, std::string("is ") + list->type_name(), "a list [ ... ]");
  for (std::size_t i = 0; i < list->size(); ++i)
    read((*list)[i], childPointer(place.pointer, std::to_string(i)));
}

}  // namespace

LightRig readLightRig(const fs::path& path) {
  const std::string file = path.string();
  const Json json = readJson(path);
  Members members(json, file, "");
  LightRig rig;
  if (members.find("units") != nullptr)
    rig.object_units = members.readChoice("units", {"object", "world"}) == 0;
  rig.windowing = readWindowing(members);
  readList(members, "lights", [&](const Json& light, const std::string& pointer) {
    rig.distant.push_back(readDistant(light, file, pointer));
  });
  readList(members, "emitters", [&](const Json& emitter, const std::string& pointer) {
    rig.emitters.push_back(readEmitter(emitter, file, pointer));
  });
  members.refuseOthers();
  if (rig.distant.empty() && rig.emitters.empty())
    throw badInput({file, "", ""}, "there is no light in it", "\"lights\", \"emitters\" or both",
                   "{\"lights\": [{\"type\": \"disk\"}]}");
  return rig;
}

LightRig readLights(const std::filesystem::path& environment_path, const std::filesystem::path& rig_path,
                    std::optional<double> windowing) {
  LightRig rig;
  if (!rig_path.empty()) rig = readLightRig(rig_path);
  if (!environment_path.empty()) {
    EnvironmentLight environment;
    environment.path = environment_path;
    ColorPicture picture = readColorPicture(environment_path, PictureUse::kLight);
    environment.image = std::move(picture.image);
    environment.notes = std::move(picture.notes);
    rig.distant.emplace_back(std::move(environment));
  }
  if (windowing) rig.windowing = *windowing;
  return rig;
}

std::vector<std::string> notesOn(const LightRig& rig) {
  std::vector<std::string> notes;
  for (const DistantLight& light : rig.distant)
    if (const auto* environment = std::get_if<EnvironmentLight>(&light))
      notes.insert(notes.end(), environment->notes.begin(), environment->notes.end());
  return notes;
}

}  // namespace bakelight::formats
