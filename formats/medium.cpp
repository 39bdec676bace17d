#include "formats/medium.h"

#include <nlohmann/json.hpp>

#include "formats/json_reader.h"

namespace bakelight::formats {
namespace {

struct MeasuredMedium {
  Float3 reduced_scattering, absorption;  // 1/mm
  double eta;
};

constexpr Word<MeasuredMedium> kMedia[] = {
    {"apple", {{2.29F, 2.39F, 1.97F}, {.0030F, .0034F, .046F}, 1.3}},
    {"chicken1", {{.15F, .21F, .38F}, {.015F, .077F, .19F}, 1.3}},
    {"chicken2", {{.19F, .25F, .32F}, {.018F, .088F, .20F}, 1.3}},
    {"cream", {{7.38F, 5.47F, 3.15F}, {.0002F, .0028F, .0163F}, 1.3}},
    {"ketchup", {{.18F, .07F, .03F}, {.061F, .97F, 1.45F}, 1.3}},
    {"marble", {{2.19F, 2.62F, 3.00F}, {.0021F, .0041F, .0071F}, 1.5}},
    {"potato", {{.68F, .70F, .55F}, {.0024F, .0090F, .12F}, 1.3}},
    {"skim_milk", {{.70F, 1.22F, 1.90F}, {.0014F, .0025F, .0142F}, 1.3}},
    {"skin1", {{.74F, .88F, 1.01F}, {.032F, .17F, .48F}, 1.3}},
    {"skin2", {{1.09F, 1.59F, 1.79F}, {.013F, .070F, .145F}, 1.3}},
    {"spectralon", {{11.6F, 20.4F, 14.9F}, {.00F, .00F, .00F}, 1.3}},
    {"whole_milk", {{2.55F, 3.21F, 3.77F}, {.0011F, .0024F, .014F}, 1.3}}};

// What a float still holds the reciprocal of.
constexpr JsonReader::Range kScattering = {1e-12, 1e12}, kAbsorption = {0, 1e12}, kEta = {1, 3},
                            kUnit = {1e-9, 1e9};
constexpr int kMostSeed = 1 << 20;

// What it is named after, if it is.
std::optional<MeasuredMedium> readCoefficients(const JsonReader& object, Float3& reduced_scattering,
                                               Float3& absorption) {
  if (!object.has("name")) {
    reduced_scattering =
        object.at("reduced_scattering", "three numbers in 1/mm, or \"name\"").float3(kScattering);
    absorption = object.at("absorption", "three numbers in 1/mm").float3(kAbsorption);
    return std::nullopt;
  }
  const MeasuredMedium& measured = object.choice("name", kMedia);
  for (const char* own : {"reduced_scattering", "absorption"})
    if (object.has(own))
      throw object.at(own).error("a medium by name has its coefficients from the table",
                                 "either \"name\", or \"reduced_scattering\" and \"absorption\"");
  reduced_scattering = measured.reduced_scattering;
  absorption = measured.absorption;
  return measured;
}

Veins veinsFrom(const JsonReader& object) {
  Veins veins;
  readCoefficients(object, veins.reduced_scattering, veins.absorption);
  veins.spacing = object.number("spacing", kUnit);
  veins.width = object.number("width", kUnit);
  if (veins.width >= veins.spacing)
    throw object.at("width").error("veins are as wide as they are apart", "less than \"spacing\"");
  object.read("seed", veins.seed, {0, kMostSeed});
  object.refuseOthers();
  return veins;
}

Json numbers(const Float3& values) {
  Json json = Json::array();
  for (const float value : values) json.push_back(shortestDouble(value));
  return json;
}

}  // namespace

std::vector<std::string> namesOfMedia() {
  return textsOf(kMedia);
}

Medium mediumFrom(const JsonReader& object) {
  Medium medium;
  if (const auto measured = readCoefficients(object, medium.reduced_scattering, medium.absorption))
    medium.eta = measured->eta;
  object.read("eta", medium.eta, kEta);
  object.read("unit_mm", medium.unit_mm, kUnit);
  object.read("model", medium.model, kDiffusionModels);
  if (const auto veins = object.find("veins")) medium.veins = veinsFrom(*veins);
  object.read("reflectance", medium.reflectance, kReflectanceSources);
  if (medium.veins && medium.reflectance == ReflectanceSource::kAlbedo)
    throw object.at("reflectance")
        .error("the albedo says what the medium is like at each place, and its \"veins\" say otherwise",
               "either \"veins\", or \"reflectance\": \"albedo\"");
  object.refuseOthers();
  return medium;
}

Json toJson(const Medium& medium) {
  Json json = {{"reduced_scattering", numbers(medium.reduced_scattering)},
               {"absorption", numbers(medium.absorption)},
               {"eta", medium.eta},
               {"unit_mm", medium.unit_mm},
               {"model", wordFor(kDiffusionModels, medium.model)}};
  if (medium.veins)
    json["veins"] = {{"reduced_scattering", numbers(medium.veins->reduced_scattering)},
                     {"absorption", numbers(medium.veins->absorption)},
                     {"spacing", medium.veins->spacing},
                     {"width", medium.veins->width},
                     {"seed", medium.veins->seed}};
  if (medium.reflectance != ReflectanceSource::kCoefficients)
    json["reflectance"] = wordFor(kReflectanceSources, medium.reflectance);
  return json;
}

}  // namespace bakelight::formats
