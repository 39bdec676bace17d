#include "formats/light_rig_file.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "formats/color_picture.h"
#include "formats/error.h"
#include "formats/json_reader.h"
#include "formats/mesh_import.h"

namespace bakelight::formats {
namespace {

namespace fs = std::filesystem;

constexpr double kLargestRadiance = 1e12;
constexpr double kLargestLength = 1e9;
constexpr double kSmallest = 1e-6;  // where a width, an angle or a period has to be more than nothing
constexpr double kAutomaticWindow = -1;

constexpr JsonReader::Range kRadiance = {0, kLargestRadiance}, kPosition = {-kLargestLength, kLargestLength},
                            kExtent = {kSmallest, kLargestLength}, kTurn = {-360, 360};

bool isZero(const Float3& v) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

void readDirection(const JsonReader& object, const char* name, Float3& value) {
  object.read(name, value, kPosition);
  if (isZero(value))
    throw badInput(object.placeOf(name), "it has no direction", "three numbers, not all zero");
}

fs::path readPath(const JsonReader& object, const char* name, const std::string& expected) {
  return object.existingFile(name, expected, "write its path relative to the folder of the light rig");
}

EnvironmentLight readEnvironment(const JsonReader& object) {
  EnvironmentLight light;
  light.path = readPath(object, "image", "an HDR image: lat-long, or a strip of six cube faces");
  ColorPicture picture = readColorPicture(light.path, PictureUse::kLight);
  light.image = std::move(picture.image);
  light.notes = std::move(picture.notes);
  const int width = light.image.width, height = light.image.height;
  if (width != 2 * height && width != 6 * height && height != 6 * width)
    throw badInput(
        object.placeOf("image"),
        light.path.string() + " is " + std::to_string(width) + " × " + std::to_string(height) + " pixels",
        "2:1 (lat-long), 6:1 or 1:6 (cube faces +X −X +Y −Y +Z −Z)");
  object.read("yaw_deg", light.yaw_deg, kTurn);
  object.read("intensity", light.intensity, kRadiance);
  return light;
}

DiskLight readDisk(const JsonReader& object) {
  DiskLight light;
  readDirection(object, "direction", light.direction);
  object.read("half_angle_deg", light.half_angle_deg, {kSmallest, 180});
  object.read("radiance", light.radiance, kRadiance);
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

PolygonLight readPolygon(const JsonReader& object) {
  PolygonLight light;
  const std::string expected = "a list of at least 3 positions [x, y, z], in order around the polygon";
  const JsonReader list = object.at("vertices", expected);
  if (!list.value().is_array() || list.size() < 3) throw list.error("it is not such a list", expected);
  for (const JsonReader& vertex : list.items()) {
    light.vertices.push_back(vertex.float3(kPosition));
    if (isZero(light.vertices.back()))
      throw vertex.error("it lies at the object itself", "a position as seen from the object");
  }
  for (std::size_t i = 0; i < list.size(); ++i)
    if (areOpposite(light.vertices[i], light.vertices[(i + 1) % list.size()]))
      throw list.at(i).error("this vertex and the next lie in opposite directions",
                             "a polygon that spans less than a hemisphere", "put a vertex between them");
  object.read("radiance", light.radiance, kRadiance);
  return light;
}

DirectionalLight readDirectional(const JsonReader& object) {
  DirectionalLight light;
  readDirection(object, "direction", light.direction);
  object.read("irradiance", light.irradiance, kRadiance);
  return light;
}

SkyLight readSky(const JsonReader& object) {
  SkyLight light;
  object.read("turbidity", light.turbidity, {1.7, 10});
  object.read("sun_elevation_deg", light.sun_elevation_deg, {-90, 90});
  object.read("sun_azimuth_deg", light.sun_azimuth_deg, kTurn);
  object.read("sun", light.sun);
  object.read("ground_albedo", light.ground_albedo, {0, 1});
  object.read("intensity", light.intensity, kRadiance);
  return light;
}

template <auto read>
DistantLight distant(const JsonReader& object) {
  return read(object);
}

constexpr Word<DistantLight (*)(const JsonReader&)> kDistantLights[] = {
    {"environment", distant<readEnvironment>}, {"disk", distant<readDisk>}, {"polygon", distant<readPolygon>},
    {"directional", distant<readDirectional>}, {"sky", distant<readSky>},
};

DistantLight readDistant(const JsonReader& object) {
  DistantLight light = object.choice("type", kDistantLights)(object);
  object.refuseOthers();
  return light;
}

constexpr Word<Motion::Kind> kMotions[] = {
    {"still", Motion::Kind::kStill}, {"orbit", Motion::Kind::kOrbit}, {"shuttle", Motion::Kind::kShuttle}};

Motion readMotion(const JsonReader& object) {
  Motion motion;
  motion.kind = object.choice("kind", kMotions);
  if (motion.kind == Motion::Kind::kOrbit) {
    readDirection(object, "axis", motion.axis);
    object.read("center", motion.center, kPosition);
  } else if (motion.kind == Motion::Kind::kShuttle) {
    motion.to = object.at("to", "the position at which it turns round").float3(kPosition);
  }
  if (motion.kind != Motion::Kind::kStill) object.read("period_s", motion.period_s, {1e-3, 1e6});
  object.refuseOthers();
  return motion;
}

constexpr Word<Emitter::Shape> kShapes[] = {
    {"quad", Emitter::Shape::kQuad}, {"sphere", Emitter::Shape::kSphere}, {"mesh", Emitter::Shape::kMesh}};

Emitter readEmitter(const JsonReader& object) {
  Emitter emitter;
  emitter.shape = object.choice("shape", kShapes);
  object.read("position", emitter.position, kPosition);
  object.read("radiance", emitter.radiance, kRadiance);
  switch (emitter.shape) {
    case Emitter::Shape::kQuad:
      readDirection(object, "normal", emitter.normal);
      object.read("width", emitter.width, kExtent);
      object.read("height", emitter.height, kExtent);
      break;
    case Emitter::Shape::kSphere:
      object.read("radius", emitter.radius, kExtent);
      break;
    case Emitter::Shape::kMesh:
      emitter.path = readPath(object, "mesh", "a mesh file, for example .obj or .ply");
      emitter.mesh = importMesh(emitter.path).mesh;
      object.read("scale", emitter.scale, kExtent);
      break;
  }
  if (const auto motion = object.find("motion")) emitter.motion = readMotion(*motion);
  object.refuseOthers();
  return emitter;
}

constexpr double kLeastSine = 1e-3;  // of the angle between a slide's direction and what is up there

Float3 cross(const Float3& a, const Float3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double lengthOf(const Float3& v) {
  return std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2]));
}

void readRequiredDirection(const JsonReader& object, Float3& value) {
  object.at("direction", "where the light shines: three numbers, not all zero");
  readDirection(object, "direction", value);
}

void readSpot(const JsonReader& object, PunctualLight& light) {
  readRequiredDirection(object, light.direction);
  object.read("outer_half_angle_deg", light.outer_half_angle_deg, {0.01, 90});
  object.read("inner_half_angle_deg", light.inner_half_angle_deg, {0, 90});
  if (light.inner_half_angle_deg >= light.outer_half_angle_deg)
    throw badInput(object.placeOf("inner_half_angle_deg"), "it is not less than outer_half_angle_deg",
                   "0 or more, and less than " + Json(light.outer_half_angle_deg).dump());
}

void readSlide(const JsonReader& object, PunctualLight& light) {
  readRequiredDirection(object, light.direction);
  readDirection(object, "up", light.up);
  if (lengthOf(cross(light.direction, light.up)) <
      kLeastSine * lengthOf(light.direction) * lengthOf(light.up))
    throw badInput(object.placeOf("up"), "it lies along the direction in which the slide shines",
                   "another direction", "\"up\": [0, 0, 1]");
  object.read("field_of_view_deg", light.field_of_view_deg, {0.01, 170});
  light.path = readPath(object, "image", "a picture");
  Image image = readColorPicture(light.path, PictureUse::kReflectance).image;
  if (std::any_of(image.values.begin(), image.values.end(), [](float value) { return value < 0; }))
    throw badInput(object.placeOf("image"), light.path.string() + " has values below 0",
                   "0 or more: shares of light");
  light.image = std::make_shared<const Image>(std::move(image));
}

constexpr Word<PunctualLight::Type> kPunctualLights[] = {{"point", PunctualLight::Type::kPoint},
                                                         {"spot", PunctualLight::Type::kSpot},
                                                         {"slide", PunctualLight::Type::kSlide}};

PunctualLight readPunctual(const JsonReader& object) {
  PunctualLight light;
  light.type = object.choice("type", kPunctualLights);
  light.position = object.at("position", "where it is: three numbers").float3(kPosition);
  object.read("intensity", light.intensity, kRadiance);
  if (light.type == PunctualLight::Type::kSpot) readSpot(object, light);
  if (light.type == PunctualLight::Type::kSlide) readSlide(object, light);
  if (const auto motion = object.find("motion")) light.motion = readMotion(*motion);
  object.refuseOthers();
  return light;
}

double readWindowing(const JsonReader& object) {
  const auto windowing = object.find("windowing");
  if (!windowing) return 0;
  if (windowing->value() == "auto") return kAutomaticWindow;
  if (windowing->value().is_string())
    throw windowing->error(windowing->value().dump() + " is not a strength",
                           "\"auto\", or a number of 0 or more", "\"auto\"");
  return windowing->number({.minimum = 0, .maximum = 1e9});
}

constexpr Word<bool> kUnits[] = {{"object", true}, {"world", false}};

}  // namespace

LightRig readLightRig(const fs::path& path) {
  const Json json = readJson(path);
  const JsonReader object(json, path.string());
  LightRig rig;
  object.read("units", rig.object_units, kUnits);
  rig.windowing = readWindowing(object);
  for (const JsonReader& light : object.items("lights")) rig.distant.push_back(readDistant(light));
  for (const JsonReader& emitter : object.items("emitters")) rig.emitters.push_back(readEmitter(emitter));
  for (const JsonReader& light : object.items("punctual")) rig.punctual.push_back(readPunctual(light));
  object.refuseOthers();
  if (rig.empty())
    throw object.error("there is no light in it", "\"lights\", \"emitters\", \"punctual\" or several",
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
