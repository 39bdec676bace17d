#include "tests/unit/report/made_report.h"

#include <cmath>
#include <random>

#include "formats/hash.h"
#include "formats/light_rig_file.h"
#include "formats/pack.h"
#include "tests/e2e/made_packs.h"
#include "tests/support/evaluate_pack.h"
#include "transport/cpu_renderer.h"
#include "transport/frame.h"
#include "transport/lighting.h"
#include "transport/near_light.h"
#include "transport/ray_scene.h"

namespace bakelight::tests {
namespace {

using formats::Json;
using transport::Vec3;

formats::Image skyWithSun() {
  formats::Image sky(64, 32, {"R", "G", "B"});
  const Vec3 sun = Vec3(0.6, 0.5, 0.7).normalized();
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x) {
      const Vec3 direction = transport::directionOfLatLong((x + 0.5) / sky.width, (y + 0.5) / sky.height);
      for (int c = 0; c < 3; ++c)
        sky.texel(x, y)[c] = static_cast<float>(0.5 + 0.2 * direction.y() * (c + 1) / 3 +
                                                (direction.dot(sun) > 0.94 ? 9 - c : 0));
    }
  return sky;
}

std::string textOf(const Vec3& v) {
  return Json(std::vector<double>{v.x(), v.y(), v.z()}).dump();
}

Json viewJson(const std::string& name, const std::string& light, const std::string& camera, double yaw_deg,
              const MadeFrame& frame) {
  return {{"name", name},
          {"light", light},
          {"camera", camera},
          {"environment", nullptr},
          {"lights", nullptr},
          {"windowing", 0},
          {"frame",
           {{"width", frame.width_px},
            {"height", frame.height_px},
            {"yaw_deg", yaw_deg},
            {"light_yaw_deg", 20},
            {"object_yaw_deg", frame.object_yaw_deg}}}};
}

// The truth by another way than the report's own: rays against the turned mesh.
formats::Image render(const formats::Pack& pack, const transport::Lighting& lighting,
                      const formats::FrameSettings& frame, const transport::OrbitCamera& camera) {
  const Eigen::Matrix3d world_from_object = transport::worldFromObject(frame);
  const Vec3 center = transport::boundingSphere(pack.mesh).center;
  const transport::ShRotation rotation(pack.sh().order,
                                       world_from_object.transpose() * transport::worldFromLight(frame));
  const auto radiance =
      transport::evaluatePack(pack, rotation.apply(lighting.distant), {},
                              world_from_object.transpose() * (camera.eye() - center) + center);
  formats::TriangleMesh turned = pack.mesh;
  transport::turnAbout(center, world_from_object, turned.positions);
  return transport::renderOnCpu(transport::RayScene(turned),
                                transport::interpolated(turned.triangles, radiance), camera,
                                {frame.width_px, frame.height_px, 2},
                                [](const Vec3&) {
                                  return formats::Float4{0, 0, 0, 0};
                                })
      .linear;
}

}  // namespace

MadeReport::MadeReport(const formats::Pack& truth, const MadeFrame& frame) {
  json = {{"asset", "made <body>"},
          {"views", Json::array()},
          {"variants", Json::array()},
          {"failed", Json::array()}};
  json["views"].push_back(viewJson("sky front", "sky", "front", 25, frame));
  json["views"].push_back(viewJson("soft side", "soft", "side", 140, frame));
  images["sky.exr"] = skyWithSun();
  json["views"][0]["environment"] = {{"path", "sky.exr"}, {"hash", "sky"}};
  for (std::size_t view = 0; view < 2; ++view)
    json["views"][view]["reference"] = addPicture("truth", truth, view, frame.noise);
}

Json MadeReport::addPicture(const std::string& name, const formats::Pack& pack, std::size_t view,
                            double noise) {
  const Json& view_json = json["views"][view];
  const formats::FrameSettings frame = formats::frameSettingsFromJson(view_json["frame"], "made", "");
  formats::LightRig rig;
  if (view == 0) rig.distant.push_back(formats::EnvironmentLight{"sky.exr", images.at("sky.exr")});
  const transport::Lighting lighting = transport::lightingFor(rig, pack.sh().order, "made");
  const transport::OrbitCamera camera = transport::frameCamera(frame, transport::boundingSphere(pack.mesh));
  const formats::Image clean = render(pack, lighting, frame, camera);

  const std::string path = name + "-" + std::to_string(view) + ".exr";
  formats::Image& image = images[path];
  image = formats::Image(clean.width, clean.height,
                         {"A", "B", "G", "R", "variance.B", "variance.G", "variance.R"});
  std::mt19937 generator(static_cast<unsigned>(view));
  std::normal_distribution<double> normal(0, 1);
  for (int y = 0; y < clean.height; ++y)
    for (int x = 0; x < clean.width; ++x) {
      const float* from = clean.texel(x, y);
      float* to = image.texel(x, y);
      to[0] = from[3];
      for (int c = 0; c < 3; ++c) {
        to[3 - c] = from[c] + static_cast<float>(from[3] > 0 ? noise * normal(generator) : 0);
        to[4 + c] = static_cast<float>(from[3] > 0 ? noise * noise : 0);
      }
    }
  metadata[path] = {{"bakelight:eye", textOf(camera.eye())},
                    {"bakelight:target", textOf(camera.target)},
                    {"bakelight:fov_deg", std::to_string(camera.field_of_view_deg)}};
  return {{"path", path}, {"hash", formats::contentHash(std::as_bytes(std::span(image.values)))}};
}

Json MadeReport::addPack(const std::string& name, const formats::Pack& pack) {
  const std::string path = name + ".glb";
  packs[path] = pack;
  return {{"path", path}, {"hash", formats::contentHash(formats::encodePack(pack, {}, path))}};
}

Json MadeReport::addReferences(const std::string& name, const formats::Pack& pack) {
  Json references = Json::array();
  for (std::size_t view = 0; view < 2; ++view) references.push_back(addPicture(name, pack, view, 0));
  return references;
}

Json& MadeReport::addVariant(const std::string& name, Json parameters, const formats::Pack& pack,
                             Json chain) {
  const auto* sh = pack.transfer.as<formats::ShTransfer>();
  const double order = sh != nullptr ? sh->order : 1;
  json["variants"].push_back({{"name", name},
                              {"parameters", std::move(parameters)},
                              {"pack", addPack("pack" + std::to_string(json["variants"].size()), pack)},
                              {"stages",
                               {{{"stage", "simplify"},
                                 {"wall_s", 1.5},
                                 {"cpu_s", 2.5},
                                 {"peak_memory_bytes", 3000000},
                                 {"bytes", 200000},
                                 {"warnings", Json::array()}},
                                {{"stage", "transfer"},
                                 {"wall_s", order * order},
                                 {"cpu_s", 2 * order * order},
                                 {"peak_memory_bytes", 90000000},
                                 {"bytes", 1000000},
                                 {"warnings", {"3 vertices are <buried>"}}}}},
                              {"left_out", Json::array()},
                              {"player", nullptr},
                              {"chain", std::move(chain)}});
  return json["variants"].back();
}

report::Plan MadeReport::plan() const {
  return report::planFromJson(json, "plan.json");
}

report::Sources MadeReport::sources() const {
  const auto image = [this](const std::filesystem::path& path) { return images.at(path.string()); };
  return {[this](const std::filesystem::path& path) { return packs.at(path.string()); },
          [this](const std::filesystem::path& path) {
            return formats::encodePack(packs.at(path.string()), {}, path.string()).size();
          },
          image, [this](const std::filesystem::path& path) { return metadata.at(path.string()); },
          [image](const std::filesystem::path& environment, const std::filesystem::path&,
                  std::optional<double> windowing) {
            formats::LightRig rig;
            rig.windowing = windowing.value_or(0);
            if (!environment.empty())
              rig.distant.push_back(formats::EnvironmentLight{environment, image(environment)});
            return rig;
          }};
}

std::filesystem::path MadeReport::write(const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  for (const auto& [path, pack] : packs) formats::writePack(folder / path, pack, {});
  for (const auto& [path, image] : images) {
    const auto known = metadata.find(path);
    formats::writeExr(folder / path, image, formats::ExrPrecision::kFloat,
                      known == metadata.end() ? std::map<std::string, std::string>() : known->second);
  }
  // Paths of the plan are absolute in the files.
  Json absolute = json;
  const Json flat = json.flatten();
  for (const auto& [pointer, value] : flat.items())
    if (pointer.ends_with("/path"))
      absolute[Json::json_pointer(pointer)] = (folder / value.get<std::string>()).string();
  formats::writeJson(folder / "plan.json", absolute);
  return folder / "plan.json";
}

formats::Pack madeGlossyPack(int order, int rings) {
  formats::Pack pack = wavyPack(order, rings);
  for (const auto& normal : pack.mesh.normals)
    pack.colors.push_back({0.6F + 0.4F * normal[0], 0.7F, 0.6F - 0.3F * normal[1]});
  addGlossyTransfer(pack, order, formats::Storage::kMatrix);
  reflectionOf(pack) = formats::PhongLobe{12, {0.4F, 0.4F, 0.4F}};
  return pack;
}

}  // namespace bakelight::tests
