#include "surface/edge_groups.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <numeric>

namespace bakelight::surface {

EdgeGroups::EdgeGroups(const SurfaceMesh& mesh) : sides_(3 * mesh.triangles.size()) {
  struct Ends {
    std::uint32_t least, greatest;
  };
  const auto ends = [&](Side side) {
    const Triangle& t = mesh.triangles[side / 3];
    const auto [least, greatest] = std::minmax(t[side % 3], t[(side % 3 + 1) % 3]);
    return Ends{least, greatest};
  };
  const std::size_t vertices = mesh.positions.size();
  // Into a bucket for each smaller vertex, in whatever order threads come; sorted within afterwards.
  std::vector<std::uint32_t> begin(vertices + 1, 0);
  const auto add = [](std::uint32_t& counter) {
    return std::atomic_ref(counter).fetch_add(1, std::memory_order_relaxed);
  };
  tbb::parallel_for(std::size_t{0}, sides_.size(),
                    [&](std::size_t s) { add(begin[ends(static_cast<Side>(s)).least + 1]); });
  std::inclusive_scan(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  tbb::parallel_for(std::size_t{0}, sides_.size(), [&](std::size_t s) {
    const auto side = static_cast<Side>(s);
    sides_[add(next[ends(side).least])] = side;
  });
  std::vector<std::uint32_t> groups(vertices + 1, 0);
  tbb::parallel_for(std::size_t{0}, vertices, [&](std::size_t v) {
    std::sort(sides_.begin() + begin[v], sides_.begin() + begin[v + 1], [&](Side a, Side b) {
      const std::uint32_t ga = ends(a).greatest, gb = ends(b).greatest;
      return ga < gb || (ga == gb && a < b);
    });
    for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i)
      groups[v + 1] += i == begin[v] || ends(sides_[i]).greatest != ends(sides_[i - 1]).greatest;
  });
  std::inclusive_scan(groups.begin(), groups.end(), groups.begin());
  first_.resize(groups.back() + 1);
  first_.back() = static_cast<std::uint32_t>(sides_.size());
  tbb::parallel_for(std::size_t{0}, vertices, [&](std::size_t v) {
    std::uint32_t g = groups[v];
    for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i) {
      if (i == begin[v] || ends(sides_[i]).greatest != ends(sides_[i - 1]).greatest) first_[g++] = i;
    }
  });
}

}  // namespace bakelight::surface
