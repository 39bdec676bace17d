#include "tools/mesomesh/synthesis/exemplar.h"

#include <cmath>
#include <utility>

#include "formats/error.h"
#include "tools/mesomesh/synthesis/symmetry.h"

namespace bakelight::mesomesh {
namespace {

constexpr int kMostChannels = 30;

void check(const formats::Image& image, const ExemplarSettings& settings, const std::string& name) {
  const ErrorPlace place{name, "", ""};
  const std::string size = std::to_string(image.width) + " × " + std::to_string(image.height) + " texels";
  if (image.width < 1 || image.height < 1 || image.channelCount() == 0)
    throw badInput(place, "the exemplar has no texel or no channel", "an image of at least one texel");
  if (image.width > kMostExemplarSide || image.height > kMostExemplarSide)
    throw badInput(place, "the exemplar has " + size,
                   "at most " + std::to_string(kMostExemplarSide) + " texels a side",
                   "crop it to a part that shows all that the texture has");
  if (!settings.periodic && (image.width < kLeastOpenSide || image.height < kLeastOpenSide))
    throw badInput(place,
                   "the exemplar has " + size +
                       " and is not periodic, so that its windows of 5 × 5 texels do not fit in",
                   "at least " + std::to_string(kLeastOpenSide) + " texels a side",
                   "use a larger exemplar, or a periodic one, which may be of any size");
  if (settings.texel_size && !(std::isfinite(*settings.texel_size) && *settings.texel_size > 0))
    throw badInput(place, "the side length of a texel is " + std::to_string(*settings.texel_size),
                   "a positive length in the asset's unit");
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (std::isfinite(image.values[i])) continue;
    const std::size_t texel = i / image.channelCount();
    throw badInput({name,
                    "texel (" + std::to_string(texel % static_cast<std::size_t>(image.width)) + ", " +
                        std::to_string(texel / static_cast<std::size_t>(image.width)) + "), channel " +
                        image.channel_names[i % image.channelCount()],
                    ""},
                   "the value is not finite", "numbers", "mend the image where it was made");
  }
}

}  // namespace

int ExemplarSymmetry::folds() const {
  if (quarter.likeness >= kSymmetricFrom) return 4;
  return half.likeness >= kSymmetricFrom ? 2 : 1;
}

Exemplar makeExemplar(const formats::Image& image, const ExemplarSettings& settings, std::string name) {
  check(image, settings, name);
  Exemplar exemplar;
  exemplar.name = std::move(name);
  exemplar.width = image.width;
  exemplar.height = image.height;
  exemplar.periodic = settings.periodic;
  exemplar.texel_size = settings.texel_size;
  const auto channels = static_cast<Eigen::Index>(image.channelCount());
  Samples values(static_cast<Eigen::Index>(exemplar.texelCount()), channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      values.row(static_cast<Eigen::Index>(image.height - 1 - y) * image.width + x) =
          Eigen::Map<const Eigen::RowVectorXf>(image.texel(x, y), channels);
  const PrincipalComponents components = principalComponents(values, kMostChannels);
  exemplar.channels = components.scores(values);
  exemplar.retained_channel_variance = components.retained_variance;
  exemplar.symmetry = measureSymmetry(exemplar);
  return exemplar;
}

}  // namespace bakelight::mesomesh
