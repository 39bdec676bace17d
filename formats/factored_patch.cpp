#include "formats/factored_patch.h"

#include <algorithm>

#include "formats/btf_reflection.h"
#include "formats/pack_contents.h"
#include "formats/rtt_reflection.h"

namespace bakelight::formats {
namespace {

void describeCode(FieldVisitor& fields, PatchCode& code) {
  fields.number("step", code.step, {.least = 0, .above = true});
  choose(fields, "precision", code.precision, kPrecisions);
  fields.integers("factorCode", code.factors, code.factors.count());
  optionally(fields, "relief", code.relief, [&](ReliefCode& relief) {
    fields.number("step", relief.step, {.least = 0, .above = true});
    fields.integers("heightCode", relief.heights, relief.heights.count());
  });
}

}  // namespace

std::vector<RttLevel> rttLevels(int width, int height) {
  std::vector<RttLevel> levels;
  for (std::size_t first = 0;; width = std::max(1, width / 2), height = std::max(1, height / 2)) {
    levels.push_back({width, height, first});
    if (width <= 1 && height <= 1) return levels;
    first += static_cast<std::size_t>(width) * height;
  }
}

std::size_t rttTexelCount(const std::vector<RttLevel>& levels) {
  return levels.back().first_texel + 1;
}

void FactoredPatch::describePatch(FieldVisitor& fields, std::size_t incident, std::size_t most_components) {
  constexpr double kMostTexels = 16384, kMostViews = 64;
  fields.integer("views", views, {1, kMostViews});
  fields.integer("width", width, {1, kMostTexels});
  fields.integer("height", height, {1, kMostTexels});
  fields.integer("components", components, {1, static_cast<double>(most_components)});
  fields.number("patchWidth", patch_width, {.least = 0, .above = true});
  const bool has_size = width >= 1 && height >= 1 && width <= kMostTexels && height <= kMostTexels;
  const std::size_t views_a_texel = static_cast<std::size_t>(views) * views;
  const std::size_t rows = has_size ? rttTexelCount(rttLevels(width, height)) * views_a_texel : 0;
  optionally(fields, "code", code, [&](PatchCode& stored) {
    constexpr std::size_t kMostValues = std::size_t{1} << 32;
    fields.require(rows * static_cast<std::size_t>(components) <= kMostValues, "code",
                   "it is of more than 4 thousand million values", "fewer texels, views or components", "");
    describeCode(fields, stored);
  });
  if (!code) {
    fields.table("factors", factors, Rows::kOther, static_cast<std::size_t>(components));
    fields.require(factors.rows == rows, "factors", "it has " + std::to_string(factors.rows) + " rows",
                   std::to_string(rows) + ", the views of each texel of each level", "");
  }
  fields.floats("basis", basis, static_cast<std::size_t>(components) * 3 * incident);
  if (!code)
    optionally(fields, "relief", heights, [&](EncodedTable& table) {
      fields.table("heights", table, Rows::kOther, 1);
      fields.require(table.rows == rows, "heights", "it has " + std::to_string(table.rows) + " rows",
                     std::to_string(rows) + ", as factors have", "");
    });
  fields.number("repeats", repeats, {.least = 0, .above = true});
  optionally(fields, "index", index, [&](PackImage& image) {
    fields.image("places", image);
    fields.require(image.channels == std::vector<std::string>{"U", "V"}, "places", "its channels are others",
                   "U and V", "");
    fields.require(image.texels.precision == Precision::kUint8, "places", "its values are not of 8 bits",
                   "uint8, as players look it up", "");
  });
}

std::vector<const PackImage*> patchIndices(const Pack& pack) {
  std::vector<const PackImage*> indices;
  const PackImage* last = nullptr;
  for (const Appearance& appearance : pack.appearances) {
    const FactoredPatch* patch = appearance.reflection.as<RttReflection>();
    if (patch == nullptr) patch = appearance.reflection.as<BtfReflection>();
    if (patch != nullptr && patch->index) last = &*patch->index;
    indices.push_back(patch == nullptr ? nullptr : last);
  }
  return indices;
}

}  // namespace bakelight::formats
