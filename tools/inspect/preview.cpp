#include "tools/inspect/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/error.h"
#include "tools/inspect/colormap.h"
#include "tools/inspect/image_figures.h"
#include "tools/inspect/render.h"
#include "tools/inspect/tensor_figures.h"
#include "transport/color.h"
#include "transport/evaluator.h"
#include "transport/glossy_evaluator.h"
#include "transport/lighting.h"
#include "transport/lights.h"
#include "transport/near_light.h"

namespace bakelight::inspect {

using formats::Image;
using formats::TriangleMesh;

namespace {

// --- pictures from arrays of another size ---

struct Cells {
  std::size_t begin, end;
};

// The source cells that a pixel covers: several when shrinking, one (repeated) when enlarging.
Cells coveredBy(int pixel, int pixels, std::size_t cells) {
  const std::size_t begin = static_cast<std::size_t>(pixel) * cells / static_cast<std::size_t>(pixels);
  const std::size_t end = static_cast<std::size_t>(pixel + 1) * cells / static_cast<std::size_t>(pixels);
  return {begin, std::max(end, begin + 1)};
}

// Sides of an image of that shape whose longer side is `size_px`.
std::array<int, 2> fittedSize(int width, int height, int size_px) {
  const double scale = static_cast<double>(size_px) / std::max(width, height);
  return {std::max(1, static_cast<int>(std::lround(width * scale))),
          std::max(1, static_cast<int>(std::lround(height * scale)))};
}

// Mean of `channels` over each pixel's texels; NaN if one of them is not finite.
Image resampled(const Image& image, const std::array<std::size_t, 3>& channels, int size_px) {
  const auto [width, height] = fittedSize(image.width, image.height, size_px);
  Image result(width, height, {"R", "G", "B"});
  for (int y = 0; y < height; ++y) {
    const Cells rows = coveredBy(y, height, static_cast<std::size_t>(image.height));
    for (int x = 0; x < width; ++x) {
      const Cells columns = coveredBy(x, width, static_cast<std::size_t>(image.width));
      const auto texels = static_cast<double>((rows.end - rows.begin) * (columns.end - columns.begin));
      for (std::size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (std::size_t row = rows.begin; row < rows.end; ++row)
          for (std::size_t column = columns.begin; column < columns.end; ++column)
            sum += image.texel(static_cast<int>(column), static_cast<int>(row))[channels[c]];
        result.texel(x, y)[c] = std::isfinite(sum) ? static_cast<float>(sum / texels) : std::nanf("");
      }
    }
  }
  return result;
}

// Applies `encode` to each value of a pixel whose three values are finite.
template <class Encode>
void encodePixels(Image& image, const Encode& encode) {
  for (std::size_t i = 0; i < image.values.size(); i += 3) {
    const bool finite = std::isfinite(image.values[i]) && std::isfinite(image.values[i + 1]) &&
                        std::isfinite(image.values[i + 2]);
    for (std::size_t c = 0; c < 3; ++c)
      image.values[i + c] = finite ? encode(image.values[i + c]) : kNotFiniteColor[c];
  }
}

// Rows are the first extent, columns all the others.
bool isTable(const formats::Tensor& tensor) {
  return tensor.shape.size() >= 2 && tensor.elementCount() > 0;
}

const std::pair<const std::string, formats::Tensor>& tableOf(const formats::TensorFile& tensors,
                                                             const std::string& file) {
  const auto named = tensors.tensors.find("transfer");
  if (named != tensors.tensors.end() && isTable(named->second)) return *named;
  for (const auto& entry : tensors.tensors)
    if (isTable(entry.second)) return entry;
  throw badInput({file, "", ""}, "no tensor is a table, there is nothing to draw",
                 "a tensor of two dimensions or more", "leave out --preview");
}

}  // namespace

Preview previewMesh(const TriangleMesh& mesh, const PreviewOptions& options, const std::string& file) {
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  const std::vector<Float3> clay = clayRadiance(mesh);
  return {render(mesh, transport::interpolated(mesh.triangles, clay), camera, defaultExposure(), options),
          mesh.normals.empty() ? "clay without shadows, with normals made for this picture"
                               : "clay without shadows, with the file's normals"};
}

Preview previewColors(const TriangleMesh& mesh, const PreviewOptions& options, const std::string& file) {
  if (mesh.colors.empty())
    throw badInput({file, "", ""}, "its vertices have no colours", "a mesh with some",
                   "draw it with --paint none");
  const transport::OrbitCamera camera = cameraFor(mesh, options, file);
  std::vector<Float3> radiance = clayRadiance(mesh);
  for (std::size_t v = 0; v < radiance.size(); ++v)
    for (std::size_t c = 0; c < 3; ++c) radiance[v][c] *= mesh.colors[v][c] / kClayAlbedo;
  return {render(mesh, transport::interpolated(mesh.triangles, radiance), camera, defaultExposure(), options),
          "colours of the vertices, without shadows"};
}

Preview previewPack(const formats::Pack& pack, const PreviewOptions& options, const std::string& file) {
  const transport::OrbitCamera camera = cameraFor(pack.mesh, options, file);
  const std::unique_ptr<transport::PackShading> shading = transport::makePackShading(pack);
  const transport::Lighting lighting = transport::defaultLighting(std::max(shading->needs().sh_order, 1));
  const transport::ShLight& light = lighting.distant;
  transport::lightShading(*shading, pack.mesh, lighting, Eigen::Matrix3d::Identity(),
                          Eigen::Matrix3d::Identity(), 0);
  shading->setView({camera.eye(), camera.pixelAngle(options.size_px * kSupersampling)});
  const double exposure = exposureFor(light);
  return {render(pack.mesh, transport::radianceOf(*shading), camera, exposure, options),
          "the pack's transfer under the default light" +
              fmt::format(", exposure {:+.2f} EV", std::log2(exposure))};
}

Preview previewImage(const Image& image, bool display_encoded, const PreviewOptions& options) {
  const auto color = colorChannels(image);
  const bool gray_scaled = !color || (image.channelCount() == 1 && !display_encoded);
  Preview preview{
      resampled(image, gray_scaled ? std::array<std::size_t, 3>{0, 0, 0} : *color, options.size_px), ""};
  if (gray_scaled) {
    const Moments channel = measureChannels(image).front();
    const double low = channel.minimum(), extent = channel.maximum() - low;
    encodePixels(preview.image,
                 [&](float value) { return extent > 0 ? static_cast<float>((value - low) / extent) : 0.5f; });
    preview.caption = "channel " + image.channel_names.front() + fmt::format(": black is {:g}", low) +
                      fmt::format(", white is {:g}", channel.maximum());
  } else if (display_encoded) {
    encodePixels(preview.image, [](float value) { return value; });
    preview.caption = "values as they stand";
  } else {
    Moments values;
    for (std::size_t i = 0; i < preview.image.values.size(); i += 3)
      values.add(
          luminance(preview.image.values[i], preview.image.values[i + 1], preview.image.values[i + 2]));
    const double exposure = values.mean() > 0 ? kMiddleValue / values.mean() : 1;
    encodePixels(preview.image, [&](float value) {
      return transport::srgbFromLinear(static_cast<float>(value * exposure));
    });
    preview.caption = "sRGB" + fmt::format(", exposure {:+.2f} EV", std::log2(exposure));
  }
  return preview;
}

Preview previewTensors(const formats::TensorFile& tensors, const PreviewOptions& options,
                       const std::string& file) {
  const auto& [name, tensor] = tableOf(tensors, file);
  const std::uint64_t row_count = tensor.shape[0], column_count = tensor.elementCount() / row_count;
  const std::uint64_t coefficients = tensor.shape.back();  // of one function on the sphere, perhaps
  const Moments moments = measureTensor(tensor);
  const double scale = std::max(std::abs(moments.minimum()), std::abs(moments.maximum()));
  const int order = orderOfColumns(coefficients);

  Image image(options.size_px, options.size_px, {"R", "G", "B"});
  for (int x = 0; x < image.width; ++x) {
    const Cells columns = coveredBy(x, image.width, column_count);
    const std::uint64_t coefficient = columns.begin % coefficients;
    const auto band = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(coefficient)));
    const bool starts_column = x > 0 && coveredBy(x - 1, image.width, column_count).begin != columns.begin;
    const bool starts_band = order > 0 && starts_column && band * band == coefficient;
    for (int y = 0; y < image.height; ++y) {
      const Cells rows = coveredBy(y, image.height, row_count);
      double sum = 0;
      for (std::uint64_t row = rows.begin; row < rows.end; ++row)
        for (std::uint64_t column = columns.begin; column < columns.end; ++column)
          sum += elementOf(tensor, row * column_count + column);
      const auto cells = static_cast<double>((rows.end - rows.begin) * (columns.end - columns.begin));
      const auto color = starts_band ? std::array<float, 3>{0.25f, 0.25f, 0.25f}
                                     : divergingColor(scale > 0 ? sum / cells / scale : 0);
      std::copy(color.begin(), color.end(), image.texel(x, y));
    }
  }
  std::string caption = "tensor " + name + ", rows down, columns across" +
                        (order > 0 ? ", lines between SH bands" : "") +
                        fmt::format(": blue is {:.4g}", -scale) +
                        fmt::format(", white is 0, red is {:.4g}; colour grows with the square root", scale);
  return {std::move(image), std::move(caption)};
}

}  // namespace bakelight::inspect
