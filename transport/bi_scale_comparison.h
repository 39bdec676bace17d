// Bi-scale packs with a part of their effects taken away, as the paper compares them (Sloan, Liu, Shum & Snyder 2003, figures
// 1, 3 and 6): what the pack loses is what that part is worth.
#pragma once

#include "formats/pack_contents.h"
#include "formats/words.h"

namespace bakelight::transport {

enum class BiScaleEffects {
  kAll,
  kNoMacro,    // the object neither shadows itself nor bounces light: M only turns the light (figures 1a, 6a)
  kNoMasking,  // every view sees what the zenith's sees: the patch looks painted on (figure 6c)
  kDiffuse,    // every view sees the mean over views
  kNoMeso      // transfer at the vertices alone, of the patch's mean albedo (figure 1b)
};
inline constexpr formats::Word<BiScaleEffects> kBiScaleEffects[] = {
    {"all", BiScaleEffects::kAll},
    {"no_macro", BiScaleEffects::kNoMacro},
    {"no_masking", BiScaleEffects::kNoMasking},
    {"diffuse", BiScaleEffects::kDiffuse},
    {"no_meso", BiScaleEffects::kNoMeso}};

// Throws std::invalid_argument for a pack that BiScaleShading does not shade, unless `effects` are all.
formats::Pack withEffects(formats::Pack pack, BiScaleEffects effects);

}  // namespace bakelight::transport
