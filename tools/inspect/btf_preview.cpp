#include "tools/inspect/btf_preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "tools/inspect/moments.h"
#include "tools/inspect/render.h"
#include "transport/color.h"
#include "transport/directions.h"

namespace bakelight::inspect {
namespace {

using formats::BtfDirection;
using formats::Image;
using transport::Vec3;

constexpr double kDegree = std::numbers::pi / 180;
// From above and from the right; light from above, then from the upper left, at ever lower angles.
constexpr BtfDirection kViews[] = {{0, 0}, {30 * kDegree, 0}, {60 * kDegree, 0}, {75 * kDegree, 0}};
constexpr double kUpperLeft = 135 * kDegree;
constexpr BtfDirection kLights[] = {
    {0, 0}, {30 * kDegree, kUpperLeft}, {60 * kDegree, kUpperLeft}, {75 * kDegree, kUpperLeft}};

Vec3 vectorOf(const BtfDirection& direction) {
  const double sine = std::sin(direction.polar_rad);
  return {sine * std::cos(direction.azimuth_rad), sine * std::sin(direction.azimuth_rad),
          std::cos(direction.polar_rad)};
}
std::vector<Vec3> vectorsOf(const std::vector<BtfDirection>& directions) {
  std::vector<Vec3> vectors;
  for (const BtfDirection& direction : directions) vectors.push_back(vectorOf(direction));
  return vectors;
}

template <class Indices>
int nearestOf(const std::vector<BtfDirection>& directions, const Indices& indices,
              const BtfDirection& wanted) {
  return *std::ranges::max_element(indices, {}, [&](int i) {
    return vectorOf(directions[static_cast<std::size_t>(i)]).dot(vectorOf(wanted));
  });
}

Image decoded(const formats::Btf& btf, const formats::BtfView& view, int light) {
  Image image(btf.info().width, btf.info().height, {"R", "G", "B"});
  const std::size_t texels = btf.texelCount();
  std::vector<float> rgb(3 * texels);
  view.decode(std::span(&light, 1), {0, texels}, rgb);
  for (std::size_t t = 0; t < texels; ++t)
    for (std::size_t c = 0; c < 3; ++c) image.values[3 * t + c] = rgb[c * texels + t];
  return image;
}

// Of any width: cells of the picture beside, averaged.
std::array<double, 3> meanOf(const Image& image, double left, double top, double right, double bottom) {
  std::array<double, 3> sum = {};
  const int x0 = static_cast<int>(left), x1 = std::max(x0 + 1, static_cast<int>(right));
  const int y0 = static_cast<int>(top), y1 = std::max(y0 + 1, static_cast<int>(bottom));
  for (int y = y0; y < std::min(y1, image.height); ++y)
    for (int x = x0; x < std::min(x1, image.width); ++x)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += image.texel(x, y)[c];
  for (double& value : sum)
    value /= static_cast<double>(std::min(x1, image.width) - x0) * (std::min(y1, image.height) - y0);
  return sum;
}

double largestPolar_deg(const std::vector<BtfDirection>& directions) {
  double largest = 0;
  for (const BtfDirection& direction : directions) largest = std::max(largest, direction.polar_rad);
  return largest / kDegree;
}

}  // namespace

BtfSheet sheetOf(const formats::Btf& btf) {
  BtfSheet sheet;
  std::vector<int> all(btf.info().views.size());
  for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<int>(v);
  for (const BtfDirection& wanted_view : kViews) {
    const int v = nearestOf(btf.info().views, all, wanted_view);
    const std::vector<int> lights = btf.lightsOf(v);
    const auto view = btf.view(v);
    for (const BtfDirection& wanted_light : kLights) {
      const int light = lights.empty() ? -1 : nearestOf(btf.info().lights, lights, wanted_light);
      sheet.pictures.push_back({v, light, light < 0 ? Image() : decoded(btf, *view, light)});
    }
  }
  return sheet;
}

std::vector<Section> describeBtf(const formats::Btf& btf, const BtfSheet& sheet) {
  const formats::BtfInfo& info = btf.info();
  std::size_t pictures = 0;
  for (std::size_t v = 0; v < info.views.size(); ++v) pictures += btf.lightsOf(static_cast<int>(v)).size();
  const double expanded = 12.0 * static_cast<double>(pictures) * static_cast<double>(btf.texelCount());
  std::vector<Section> sections = {
      {"size",
       {{"layout", info.layout, ""},
        {"width_texels", info.width, "texels"},
        {"height_texels", info.height, "texels"},
        {"pictures", pictures, ""},
        {"missing_pictures", info.views.size() * info.lights.size() - pictures, ""},
        {"expanded_bytes", expanded, "bytes"},
        {"compression",
         info.bytes > 0 ? formats::Json(expanded / static_cast<double>(info.bytes)) : formats::Json(), ""}},
       {},
       {}}};
  Section directions{"directions", {}, {"of", "count", "largest_polar_deg", "largest_gap_deg"}, {}};
  for (const auto& [name, list] : {std::pair("views", &info.views), std::pair("lights", &info.lights)})
    directions.rows.push_back({name, list->size(), largestPolar_deg(*list),
                               transport::largestGap(vectorsOf(*list)).angle_rad / kDegree});
  sections.push_back(std::move(directions));
  sections.push_back({"measurement",
                      {{"cosine_inside", info.cosine_inside, ""},
                       {"texels_per_mm", info.texels_per_mm, ""},
                       {"setup", info.measurement_setup, ""},
                       {"image_sensor", info.image_sensor, ""},
                       {"light_source", info.light_source, ""}},
                      {},
                      {}});
  Section values{"pictures", {}, {"view_deg", "light_deg", "minimum", "mean", "maximum"}, {}};
  const auto angles = [](const BtfDirection& direction) {
    return fmt::format("{:.4g}, {:.4g}", direction.polar_rad / kDegree, direction.azimuth_rad / kDegree);
  };
  for (const BtfSheet::Picture& picture : sheet.pictures) {
    if (picture.light < 0) continue;
    Moments moments;
    for (const float value : picture.image.values) moments.add(static_cast<double>(value));
    values.rows.push_back({angles(info.views[static_cast<std::size_t>(picture.view)]),
                           angles(info.lights[static_cast<std::size_t>(picture.light)]), moments.minimum(),
                           moments.mean(), moments.maximum()});
  }
  sections.push_back(std::move(values));
  if (!info.notes.empty()) {
    Section notes{"notes", {}, {"note"}, {}};
    for (const std::string& note : info.notes) notes.rows.push_back({note});
    sections.push_back(std::move(notes));
  }
  return sections;
}

Preview previewBtf(const formats::Btf& btf, const BtfSheet& sheet, const PreviewOptions& options) {
  constexpr int kGap = 2;  // px
  constexpr float kNothing = 0.1F;
  const int columns = BtfSheet::kColumns, rows = static_cast<int>(sheet.pictures.size()) / columns;
  const int longer = std::max(btf.info().width, btf.info().height);
  const int cell = std::max((options.size_px - kGap * (columns - 1)) / columns, 1);
  const int width = std::max(cell * btf.info().width / longer, 1),
            height = std::max(cell * btf.info().height / longer, 1);
  Moments moments;
  for (const BtfSheet::Picture& picture : sheet.pictures)
    for (const float value : picture.image.values) moments.add(static_cast<double>(value));
  const double exposure = moments.mean() > 0 ? kMiddleValue / moments.mean() : 1;
  Preview preview;
  preview.image =
      Image(columns * width + (columns - 1) * kGap, rows * height + (rows - 1) * kGap, {"R", "G", "B"});
  std::ranges::fill(preview.image.values, kNothing);
  for (std::size_t p = 0; p < sheet.pictures.size(); ++p) {
    const Image& picture = sheet.pictures[p].image;
    if (picture.values.empty()) continue;
    const int left = static_cast<int>(p) % columns * (width + kGap),
              top = static_cast<int>(p) / columns * (height + kGap);
    const double across = static_cast<double>(picture.width) / width,
                 down = static_cast<double>(picture.height) / height;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::array<double, 3> mean =
            meanOf(picture, x * across, y * down, (x + 1) * across, (y + 1) * down);
        for (std::size_t c = 0; c < 3; ++c)
          preview.image.texel(left + x, top + y)[c] =
              transport::srgbFromLinear(static_cast<float>(mean[c] * exposure));
      }
  }
  preview.caption =
      "views at 0, 30, 60 and 75° from above down, lights at 0, 30, 60 and 75° across, or the nearest" +
      fmt::format("; sRGB, exposure {:+.2f} EV", std::log2(exposure));
  return preview;
}

}  // namespace bakelight::inspect
