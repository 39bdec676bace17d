#include <algorithm>
#include <cmath>
#include <random>

#include "tools/atlas/maps/raster.h"
#include "tools/dilate/dilate.h"

using namespace bakelight;
using atlas::RowSpan;
using atlas::TexelTriangle;
using atlas::Vec2;

namespace {

constexpr int kSide = 128;

// Triangles strewn over a square, with `gutter` free texels at least between any two.
class Charts {
 public:
  explicit Charts(int gutter) : image(kSide, kSide, {"chart"}), covered(kSide * kSide, 0) {
    std::mt19937 engine(11);
    std::uniform_real_distribution<double> place(0, kSide), way(-9, 9);
    std::vector<RowSpan> spans;
    for (int attempt = 0; attempt < 20000; ++attempt) {
      const Vec2 a(place(engine), place(engine));
      const TexelTriangle triangle = {a, a + Vec2(way(engine), way(engine)),
                                      a + Vec2(way(engine), way(engine))};
      const bool is_inside = std::all_of(triangle.begin(), triangle.end(), [](const Vec2& p) {
        return p.minCoeff() >= 0 && p.maxCoeff() <= kSide;
      });
      if (!is_inside) continue;
      touchedSpans(triangle, kSide, spans);
      if (!isFree(spans, gutter)) continue;
      for (const RowSpan& span : spans)
        for (int i = span.begin; i < span.end; ++i) {
          covered[span.row * kSide + i] = 1;
          image.texel(i, span.row)[0] = static_cast<float>(triangles.size());
        }
      triangles.push_back(triangle);
    }
  }

  formats::Image image;
  std::vector<std::uint8_t> covered;
  std::vector<TexelTriangle> triangles;

 private:
  bool isFree(const std::vector<RowSpan>& spans, int gutter) const {
    for (const RowSpan& span : spans)
      for (int j = std::max(span.row - gutter, 0); j <= std::min(span.row + gutter, kSide - 1); ++j)
        for (int i = std::max(span.begin - gutter, 0); i < std::min(span.end + gutter, kSide); ++i)
          if (covered[j * kSide + i] != 0) return false;
    return true;
  }
};

// Points of charts whose bilinear footprint reads another chart.
int pointsThatSeeOthers(const Charts& charts, const formats::Image& texture) {
  std::mt19937 engine(12);
  std::uniform_real_distribution<double> share(0, 1);
  int seen = 0;
  for (std::size_t chart = 0; chart < charts.triangles.size(); ++chart)
    for (int n = 0; n < 2000; ++n) {
      // On an edge half of the time, where footprints reach out furthest.
      const double u = share(engine), v = n % 2 == 0 ? 0 : share(engine) * (1 - u);
      const TexelTriangle& t = charts.triangles[chart];
      const std::size_t k = static_cast<std::size_t>(n / 2) % 3;
      const Vec2 p = t[k] + u * (t[(k + 1) % 3] - t[k]) + v * (t[(k + 2) % 3] - t[k]);
      const int i = static_cast<int>(std::floor(p.x() - 0.5)), j = static_cast<int>(std::floor(p.y() - 0.5));
      bool is_own = true;
      for (const auto& [x, y] : {std::pair(i, j), {i + 1, j}, {i, j + 1}, {i + 1, j + 1}})
        is_own = is_own && texture.texel(std::clamp(x, 0, kSide - 1), std::clamp(y, 0, kSide - 1))[0] ==
                               static_cast<float>(chart);
      seen += !is_own;
    }
  return seen;
}

TEST(Gutter, OfTwoTexelsNeverShowsAnotherChart) {
  for (const int gutter : {2, 3}) {
    const Charts charts(gutter);
    ASSERT_GT(charts.triangles.size(), 100u);
    const formats::Image texture =
        dilate::dilated(charts.image, charts.covered, {dilate::Method::kNearest, 0}).image;
    EXPECT_EQ(pointsThatSeeOthers(charts, texture), 0);
    EXPECT_GT(pointsThatSeeOthers(charts, charts.image), 0) << "without dilation";
  }
}

// So the two texels are needed.
TEST(Gutter, OfNoTexelsDoes) {
  const Charts charts(0);
  const formats::Image texture =
      dilate::dilated(charts.image, charts.covered, {dilate::Method::kNearest, 0}).image;
  EXPECT_GT(pointsThatSeeOthers(charts, texture), 0);
}

}  // namespace
