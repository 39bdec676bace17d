// A scattering medium that an object consists of: what lets light through below its surface.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/json.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::formats {

class JsonReader;

// How light that has entered comes out again (transport/diffusion.h).
enum class DiffusionModel { kDipole, kBetterDipole, kNormalizedDiffusion };
inline constexpr Word<DiffusionModel> kDiffusionModels[] = {
    {"dipole", DiffusionModel::kDipole},
    {"better_dipole", DiffusionModel::kBetterDipole},
    {"normalized_diffusion", DiffusionModel::kNormalizedDiffusion}};

// What a half space of it reflects of even light that has entered: what its coefficients say, or the material's albedo, be it a color, a texture or
// the mesh's colors. Then the medium gives the mean free path 1/σt′ alone, and α′ is found for each color of each place ("albedo inversion": Jensen and Buhler 2002,
// "A Rapid Hierarchical Rendering Technique for Translucent Materials", section 4; Chiang, Kutz and Burley 2016, "Practical and Controllable Subsurface Scattering
// for Production Path Tracing").
enum class ReflectanceSource { kCoefficients, kAlbedo };
inline constexpr Word<ReflectanceSource> kReflectanceSources[] = {
    {"coefficients", ReflectanceSource::kCoefficients}, {"albedo", ReflectanceSource::kAlbedo}};

// Another medium in thin sheets all through one: about where noise is 0 (Perlin 1985, "An Image Synthesizer"). Lengths are in the
// asset's unit.
struct Veins {
  Float3 reduced_scattering = {1, 1, 1};  // σs′, in 1/mm, > 0
  Float3 absorption = {0, 0, 0};          // σa, in 1/mm, ≥ 0
  double spacing = 1;                     // of the noise: veins are about as far apart, > 0
  double width = 0.1;  // where half of what is there is the veins' medium, > 0 and less than `spacing`
  int seed = 0;        // of the noise; others are elsewhere
  bool operator==(const Veins&) const = default;
};

// Red, green and blue.
struct Medium {
  Float3 reduced_scattering = {1, 1, 1};  // σs′, in 1/mm, > 0
  Float3 absorption = {0, 0, 0};          // σa, in 1/mm, ≥ 0
  double eta = 1.3;                       // index of refraction, 1–3
  double unit_mm = 1;                     // millimetres in the asset's unit of length
  DiffusionModel model = DiffusionModel::kDipole;
  std::optional<Veins> veins = {};  // none where the albedo is the reflectance
  ReflectanceSource reflectance = ReflectanceSource::kCoefficients;
  bool operator==(const Medium&) const = default;
};

// Measured ones (Jensen, Marschner, Levoy and Hanrahan 2001, figure 5), and what stands for none of them.
std::vector<std::string> namesOfMedia();

// {"name": one of namesOfMedia()} or {"reduced_scattering": …, "absorption": …}, with "eta", "unit_mm", "model", "veins" and "reflectance". Throws
// Error(kBadInput) as JsonReader.
Medium mediumFrom(const JsonReader& object);
Json toJson(const Medium& medium);  // by coefficients

}  // namespace bakelight::formats
