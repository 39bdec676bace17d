#include "tools/btf/rewriting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "transport/btf_factorization.h"

namespace bakelight::btf {

double relativeError(const formats::Btf& btf, const formats::Btf& expected) {
  constexpr std::size_t kBlock = 256;
  const std::size_t texels = expected.texelCount(), blocks = (texels + kBlock - 1) / kBlock;
  double differences = 0, squares = 0;
  for (std::size_t v = 0; v < expected.info().views.size(); ++v) {
    const auto view = btf.view(static_cast<int>(v)), expected_view = expected.view(static_cast<int>(v));
    const std::vector<int> lights = expected.lightsOf(static_cast<int>(v));
    std::vector<std::array<double, 2>> partial(blocks);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
      const std::size_t first = block * kBlock, count = std::min(kBlock, texels - first);
      std::vector<float> a(3 * lights.size() * count), b(a.size());
      view->decode(lights, {first, count}, a);
      expected_view->decode(lights, {first, count}, b);
      for (std::size_t i = 0; i < a.size(); ++i) {
        const double difference = static_cast<double>(a[i]) - b[i];
        partial[block][0] += difference * difference;
        partial[block][1] += static_cast<double>(b[i]) * b[i];
      }
    });
    for (const auto& [difference, square] : partial) differences += difference, squares += square;
  }
  return squares > 0 ? std::sqrt(differences / squares) : std::sqrt(differences);
}

RewritingFigures rewrite(const formats::Btf& btf, const std::filesystem::path& path,
                         const RewritingOptions& options) {
  RewritingFigures figures;
  if (options.layout == Layout::kRaw) {
    formats::writeRawBtf(path, btf);
  } else {
    const transport::BtfFactorization factorization = transport::factorize(btf, options.model, options.rank);
    formats::writeFactorizedBtf(path, btf.info(), options.model, factorization.channels, options.precision);
    for (const formats::BtfFactors& factors : factorization.channels) figures.ranks.push_back(factors.rank);
    figures.channel_errors = factorization.relative_errors;
    figures.negative_values = factorization.negative_values;
  }
  figures.bytes = std::filesystem::file_size(path);
  figures.relative_error = relativeError(*formats::openBtf(path), btf);
  return figures;
}

}  // namespace bakelight::btf
