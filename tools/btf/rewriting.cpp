#include "tools/btf/rewriting.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

#include "transport/btf_factorization.h"

namespace bakelight::btf {

namespace {

// All of it in memory, if that is not much: it is gone through seven times. Null if it is, or has gaps.
std::unique_ptr<formats::Btf> held(const formats::Btf& btf) {
  constexpr std::size_t kMost = std::size_t{1} << 28;  // values, 1 GiB
  const std::vector<int> lights = btf.Btf::lightsOf(0);
  const std::size_t views = btf.info().views.size(), texels = btf.texelCount();
  const std::size_t a_view = 3 * lights.size() * texels;
  if (a_view > kMost / views) return nullptr;
  for (std::size_t v = 0; v < views; ++v)
    if (btf.lightsOf(static_cast<int>(v)).size() != lights.size()) return nullptr;
  std::vector<float> values(views * a_view);
  constexpr std::size_t kBlock = 256;
  for (std::size_t v = 0; v < views; ++v) {
    const auto view = btf.view(static_cast<int>(v));
    tbb::parallel_for(std::size_t{0}, (texels + kBlock - 1) / kBlock, [&](std::size_t block) {
      const std::size_t first = block * kBlock, count = std::min(kBlock, texels - first);
      std::vector<float> rgb(3 * lights.size() * count);
      view->decode(lights, {first, count}, rgb);
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t l = 0; l < lights.size(); ++l)
          for (std::size_t t = 0; t < count; ++t)
            values[v * a_view + (l * texels + first + t) * 3 + c] = rgb[(c * lights.size() + l) * count + t];
    });
  }
  return formats::btfOf(btf.info(), std::move(values));
}

}  // namespace

RewritingFigures rewrite(const formats::Btf& given, const std::filesystem::path& path,
                         const RewritingOptions& options) {
  const std::unique_ptr<formats::Btf> in_memory = held(given);
  const formats::Btf& btf = in_memory ? *in_memory : given;
  RewritingFigures figures;
  if (options.layout == formats::BtfWrittenLayout::kRaw) {
    formats::writeRawBtf(path, btf);
  } else {
    const transport::BtfFactorization factorization = transport::factorize(btf, options.model, options.rank);
    formats::writeFactorizedBtf(path, btf.info(), options.model, factorization.channels, options.precision);
    for (const formats::BtfFactors& factors : factorization.channels) figures.ranks.push_back(factors.rank);
    figures.channel_errors = factorization.relative_errors;
    figures.negative_values = factorization.negative_values;
  }
  figures.bytes = std::filesystem::file_size(path);
  figures.relative_error = transport::relativeError(*formats::openBtf(path), btf);
  return figures;
}

}  // namespace bakelight::btf
