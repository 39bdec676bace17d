// Radiance transfer textures (RTT; Sloan, Liu, Shum & Snyder 2003, "Bi-Scale Radiance Transfer", section 4.2):
// what a patch of meso-structure sends towards each view, of each spherical harmonic of the light on it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "formats/image.h"

namespace bakelight::formats {

// B(u, v): the radiance at place u of the patch towards view v is Σ_i B_i · light_i, where light_i are the
// coefficients of the radiance that falls on the patch, in the patch's frame: x along its u (to the right), y
// along its v (up), z out of it. Cosines are inside; the albedo is, too. Distances beside the patch do not
// matter: it has no size here but in texels.
struct RadianceTransferTexture {
  std::string material;  // whose patch it is; "" is the asset's own
  int order = 0;         // bands, 1–10: order² coefficients
  int views = 1;         // a side of the grid of views (transport/hemisphere_grid.h); 1: the same towards all
  int width = 0, height = 0;       // texels
  std::vector<float> values = {};  // see `response`
  // Of the highest that each texel shows towards a view, in widths of the patch above its mid-plane: where a view shows what
  // another shows elsewhere. In the order of responses, one each; empty where nothing is known of it, as of what was measured.
  std::vector<float> heights = {};

  std::size_t coefficientCount() const { return static_cast<std::size_t>(order) * order; }
  std::size_t responseSize() const { return 3 * coefficientCount(); }
  std::size_t texelCount() const { return static_cast<std::size_t>(width) * height; }
  std::size_t viewCount() const { return static_cast<std::size_t>(views) * views; }
  // Zeros of the size that the members above have.
  void allocate() { values.assign(responseCount() * responseSize(), 0.0F); }
  std::size_t responseCount() const { return viewCount() * texelCount(); }
  // 3 × order² values, all of red, then of green, then of blue. View (column, row) is the grid's cell; texel
  // (x, y) counts from the upper left, as in images: its middle is u = (x + ½)/width, v = 1 − (y + ½)/height.
  std::size_t responseIndex(int view_column, int view_row, int x, int y) const {
    return (static_cast<std::size_t>(view_row) * views + view_column) * texelCount() +
           static_cast<std::size_t>(y) * width + x;
  }
  std::size_t offset(int view_column, int view_row, int x, int y) const {
    return responseIndex(view_column, view_row, x, y) * responseSize();
  }
  std::span<float> response(int view_column, int view_row, int x, int y) {
    return std::span(values).subspan(offset(view_column, view_row, x, y), responseSize());
  }
  std::span<const float> response(int view_column, int view_row, int x, int y) const {
    return std::span(values).subspan(offset(view_column, view_row, x, y), responseSize());
  }
};

// One OpenEXR image (docs/FORMATS.md, "Radiance transfer textures"): the textures one below the other; each is
// a picture of pictures, one a view, the zenith's in the middle, +x to the right and +y up. Channels "sh00.R",
// "sh00.G", … by coefficient; "height" if a texture has heights. Atomic. Throws std::logic_error for textures of different orders, values of
// another number or two of one material; Error(kBadInput) as writeExr does.
void writeRadianceTransferTextures(const std::filesystem::path& path,
                                   std::span<const RadianceTransferTexture> textures,
                                   ExrPrecision precision = ExrPrecision::kHalf);

// Throws Error(kBadInput) naming file and what is wrong with it: no such image, channels or metadata that do not fit
// it, values not finite.
std::vector<RadianceTransferTexture> readRadianceTransferTextures(const std::filesystem::path& path);

// Whether the file is an OpenEXR image that says it holds such textures.
bool isRadianceTransferTexture(const std::filesystem::path& path);

}  // namespace bakelight::formats
