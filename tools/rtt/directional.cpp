#include "tools/rtt/directional.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "tools/rtt/baking.h"
#include "tools/rtt/elements.h"
#include "transport/hemisphere_grid.h"

namespace bakelight::rtt {
namespace {

using Clock = std::chrono::steady_clock;

std::vector<formats::BtfDirection> gridDirections(int side) {
  std::vector<formats::BtfDirection> directions;
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column) {
      const Vec3 middle = transport::hemisphereCell(side, column, row);
      directions.push_back(
          {std::atan2(std::hypot(middle.x(), middle.y()), middle.z()), std::atan2(middle.y(), middle.x())});
    }
  return directions;
}

using Values = std::shared_ptr<const std::vector<float>>;  // of Responses

class RenderedView : public formats::BtfView {
 public:
  RenderedView(std::shared_ptr<const formats::BtfInfo> info, int view, Values values)
      : BtfView(std::move(info), view), values_(std::move(values)) {}

 private:
  void decodeValues(std::span<const int> lights, formats::BtfTexels texels,
                    std::span<float> rgb) const override {
    const std::size_t all = info().lights.size();
    const std::size_t first = static_cast<std::size_t>(index()) * info().width * info().height + texels.first;
    for (std::size_t t = 0; t < texels.count; ++t) {
      const float* response = &(*values_)[(first + t) * 3 * all];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < lights.size(); ++i)
          rgb[(c * lights.size() + i) * texels.count + t] =
              response[c * all + static_cast<std::size_t>(lights[i])];
    }
  }

  Values values_;
};

class RenderedBtf : public formats::Btf {
 public:
  RenderedBtf(formats::BtfInfo info, Values values) : Btf(std::move(info)), values_(std::move(values)) {}
  std::shared_ptr<const formats::BtfView> view(int view) const override {
    return std::make_shared<RenderedView>(sharedInfo(), view, values_);
  }

 private:
  Values values_;
};

formats::Float3 meanAlbedoOf(const Responses& responses) {
  const std::size_t texels = static_cast<std::size_t>(responses.width) * responses.height;
  const int views = responses.views * responses.views;
  std::vector<std::array<double, 3>> parts(static_cast<std::size_t>(views));
  tbb::parallel_for(0, views, [&](int view) {
    const double cosine =
        transport::hemisphereCell(responses.views, view % responses.views, view / responses.views).z();
    const float* value = &responses.values[static_cast<std::size_t>(view) * texels * responses.size()];
    for (std::size_t t = 0; t < texels; ++t)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < responses.coefficients; ++i)
          parts[static_cast<std::size_t>(view)][c] += cosine * *value++;
  });
  std::array<double, 3> sums = {};
  const double cell_sr = cellSolidAngle(static_cast<int>(std::lround(std::sqrt(responses.coefficients))));
  for (const auto& part : parts)
    for (std::size_t c = 0; c < 3; ++c) sums[c] += cell_sr * part[c];
  return meanAlbedo(sums, responses.views, texels);
}

}  // namespace

double btfBytes(const Options& options, const BtfOptions& btf, double aspect) {
  return std::pow(static_cast<double>(options.views) * btf.lights, 2) * options.resolution *
         texelsDown(options, aspect) * 3 * sizeof(float);
}

double lightBytes(const patch::PatchGeometry& geometry, const Options& options, const BtfOptions& btf) {
  double longest_edge = 1.0 / options.elements;
  return static_cast<double>(withElements(geometry, longest_edge).mesh.vertexCount()) * btf.lights *
         btf.lights * 3 * sizeof(float);
}

DirectionalBtf makeBtf(const patch::PatchGeometry& geometry, const Options& options, const BtfOptions& btf,
                       const std::string& file, const std::function<void()>& progress) {
  Baking baking(geometry, options, LightBasis::cells(btf.lights));
  baking.solve(cellLights(btf.lights, btf.light_samples));
  formats::BtfInfo info;
  info.file = file;
  info.layout = "rendered";
  info.views = gridDirections(options.views), info.lights = gridDirections(btf.lights);
  info.width = options.resolution, info.height = texelsDown(options, geometry.aspect);
  info.cosine_inside = true;
  info.measurement_setup = "Bakelight rtt";
  const auto values = std::make_shared<std::vector<float>>(
      static_cast<std::size_t>(btfBytes(options, btf, geometry.aspect)) / sizeof(float));
  const Responses responses{options.views, info.width, info.height, info.lights.size(), *values};
  const auto viewing = Clock::now();
  const ViewFigures seen = baking.render(progress, responses);
  DirectionalBtf made;
  made.figures = baking.figures(seen);
  made.figures.views_s = std::chrono::duration<double>(Clock::now() - viewing).count();
  made.figures.mean_albedo = meanAlbedoOf(responses);
  made.btf = std::make_unique<RenderedBtf>(std::move(info), values);
  made.rendered = values;
  return made;
}

}  // namespace bakelight::rtt
