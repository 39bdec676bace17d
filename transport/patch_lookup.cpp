#include "transport/patch_lookup.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bakelight::transport {
namespace {

using formats::Float2;

int texelOf(double place, int count) {
  return std::clamp(static_cast<int>(place * count), 0, count - 1);
}

double fraction(double x) {
  return x - std::floor(x);
}

int wrapped(int i, int count) {
  i %= count;
  return i < 0 ? i + count : i;
}

}  // namespace

float leastReliefCosine(int views) {
  return std::min(kLeastReliefCosine, static_cast<float>(hemisphereCell(views, 0, 0).z()));
}

Float2 reliefSlope(const Vec3& direction, float least_cosine) {
  const double z = std::max(direction.z(), double{least_cosine});
  return {static_cast<float>(direction.x() / z), static_cast<float>(direction.y() / z)};
}

double rttLevelOf(double distance, double pixel_angle, double cosine, double texel_width) {
  const double covered = distance * pixel_angle / (texel_width * std::sqrt(std::max(cosine, 0.01)));
  return covered > 1 ? std::log2(covered) : 0;
}

RttLevels rttLevelsAt(double level, std::size_t count) {
  level = std::min(level, static_cast<double>(count - 1));
  const auto fine = static_cast<std::size_t>(level);
  constexpr double kFirst = 0.35, kLast = 0.65;
  const double blend = std::clamp((level - static_cast<double>(fine) - kFirst) / (kLast - kFirst), 0.0, 1.0);
  if (blend >= 1) return {fine + 1, 0};
  return {fine, static_cast<float>(blend)};
}

Eigen::Matrix3d localFrame(const Float3& normal, const formats::Float4& tangent) {
  const Vec3 n = vec3(normal).normalized(), along(tangent[0], tangent[1], tangent[2]);
  Eigen::Matrix3d local;
  local.row(0) = (along - along.dot(n) * n).normalized();
  local.row(2) = n;
  local.row(1) = tangent[3] * n.cross(Vec3(local.row(0)));
  return local;
}

std::array<float, 3> cornerWeights(const SurfaceHit& hit) {
  return {1 - hit.u - hit.v, hit.u, hit.v};
}

SeenPoint seenPoint(const formats::TriangleMesh& mesh, std::span<const formats::Float4> tangents,
                    const SurfaceHit& hit, const std::array<float, 3>& frame_weights, const Vec3& eye) {
  SeenPoint at;
  at.corners = mesh.triangles[hit.triangle];
  at.weights = cornerWeights(hit);
  if (!mesh.triangle_materials.empty()) at.appearance = mesh.triangle_materials[hit.triangle];
  Vec3 position = Vec3::Zero(), normal = Vec3::Zero(), tangent = Vec3::Zero();
  float handedness = tangents[at.corners[0]][3];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = at.corners[k];
    const double frame_weight = frame_weights[k];
    position += double{at.weights[k]} * vec3(mesh.positions[v]);
    normal += frame_weight * vec3(mesh.normals[v]);
    tangent += frame_weight * Vec3(tangents[v][0], tangents[v][1], tangents[v][2]);
    if (frame_weight == 1) handedness = tangents[v][3];
    if (mesh.texcoords.empty()) continue;
    for (std::size_t c = 0; c < 2; ++c) at.texcoord[c] += at.weights[k] * mesh.texcoords[v][c];
  }
  const Float3 t = float3(tangent);
  const Vec3 offset = eye - position;
  at.distance = offset.norm();
  if (at.distance > 0 && normal.norm() > 0)
    at.to_eye = localFrame(float3(normal), {t[0], t[1], t[2], handedness}) * (offset / at.distance);
  return at;
}

PatchLookup::PatchLookup(const formats::FactoredPatch& patch, const formats::PackImage* index)
    : views_(patch.views),
      components_(static_cast<std::size_t>(patch.components)),
      texel_width_(double{patch.patch_width} / patch.width),
      repeats_(patch.repeats),
      aspect_(static_cast<double>(patch.width) / patch.height),
      least_cosine_(leastReliefCosine(patch.views)),
      levels_(formats::rttLevels(patch.width, patch.height)),
      factors_(patch.factors.decode()) {
  const std::size_t rows = formats::rttTexelCount(levels_) * viewCount();
  if (factors_.size() != rows * components_)
    throw std::invalid_argument("factors of a patch do not fit its size");
  if (patch.heights) {
    heights_ = patch.heights->decode();
    if (heights_.size() != rows) throw std::invalid_argument("heights of a patch do not fit its size");
    highest_ = *std::max_element(heights_.begin(), heights_.end());
  }
  for (int row = 0; row < views_; ++row)
    for (int column = 0; column < views_; ++column)
      slopes_.push_back(reliefSlope(hemisphereCell(views_, column, row), least_cosine_));
  if (index == nullptr) return;
  if (index->texels.columns != 2 || index->texels.precision != formats::Precision::kUint8)
    throw std::invalid_argument("an index has two channels of 8 bits");
  index_width_ = index->width;
  index_height_ = index->height;
  index_.resize(index->texels.data.size());
  std::transform(index->texels.data.begin(), index->texels.data.end(), index_.begin(),
                 [](std::byte code) { return static_cast<std::uint8_t>(code); });
  std::copy_n(index->texels.scale.begin(), 2, index_scale_.begin());
  std::copy_n(index->texels.offset.begin(), 2, index_offset_.begin());
}

Float2 PatchLookup::placeOf(const Float2& texcoord) const {
  if (index_.empty()) {
    const double u = texcoord[0] * repeats_, v = texcoord[1] * repeats_ * aspect_;
    return {static_cast<float>(fraction(u)), static_cast<float>(fraction(v))};
  }
  const int x = texelOf(texcoord[0], index_width_), y = texelOf(1.0 - texcoord[1], index_height_);
  const std::uint8_t* codes = &index_[2 * (static_cast<std::size_t>(y) * index_width_ + x)];
  return {index_offset_[0] + index_scale_[0] * codes[0], index_offset_[1] + index_scale_[1] * codes[1]};
}

// Linear between texels: heights that jump from texel to texel would make places jump with the last digit.
float PatchLookup::heightAt(const formats::RttLevel& level, const Float2& place, std::size_t view) const {
  const float x = place[0] * static_cast<float>(level.width) - 0.5F,
              y = (1 - place[1]) * static_cast<float>(level.height) - 0.5F;
  const float left = std::floor(x), top = std::floor(y), across = x - left, down = y - top;
  const auto at = [&](int i, int j) {
    const std::size_t texel =
        level.first_texel +
        static_cast<std::size_t>(wrapped(static_cast<int>(top) + j, level.height)) * level.width +
        static_cast<std::size_t>(wrapped(static_cast<int>(left) + i, level.width));
    return heights_[texel * viewCount() + view];
  };
  return (1 - down) * ((1 - across) * at(0, 0) + across * at(1, 0)) +
         down * ((1 - across) * at(0, 1) + across * at(1, 1));
}

std::array<PatchLookup::View, 4> PatchLookup::viewsAt(const formats::RttLevel& level, const Float2& place,
                                                      const Vec3& to_eye) const {
  std::array<View, 4> found;
  if (views_ == 1) {
    found[0] = {0, 1, place};
    return found;
  }
  const GridPosition at = gridPosition(views_, to_eye);
  const Float2 slope = reliefSlope(to_eye, least_cosine_);
  const auto width = static_cast<float>(level.width), height = static_cast<float>(level.height);
  const auto aspect = static_cast<float>(aspect_);
  float total = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const int i = static_cast<int>(k) % 2, j = static_cast<int>(k) / 2;
    View& one = found[k];
    one.weight = (i == 0 ? 1 - at.across : at.across) * (j == 0 ? 1 - at.up : at.up);
    one.view = static_cast<std::size_t>(at.row + j) * static_cast<std::size_t>(views_) +
               static_cast<std::size_t>(at.column + i);
    one.place = place;
    if (!heights_.empty() && one.weight > 0) {
      const Float2 shift = {slope[0] - slopes_[one.view][0], (slope[1] - slopes_[one.view][1]) * aspect};
      const auto shifted = [&](float h) { return Float2{place[0] + h * shift[0], place[1] + h * shift[1]}; };
      Float2 last = place;
      one.place = shifted(kReliefStart * highest_);
      for (int step = 0; step < kReliefSteps; ++step) {
        last = one.place;
        one.place = shifted(heightAt(level, last, one.view));
      }
      const float off_x = (one.place[0] - last[0]) * width, off_y = (one.place[1] - last[1]) * height;
      one.weight *= kUnseenReliefWeight + std::exp(-(off_x * off_x + off_y * off_y));
    }
    total += one.weight;
  }
  for (View& one : found) one.weight /= total;
  return found;
}

void PatchLookup::add(const formats::RttLevel& level, const View& view, float weight,
                      std::span<float> sum) const {
  const int x = texelOf(fraction(view.place[0]), level.width),
            y = texelOf(fraction(1 - view.place[1]), level.height);
  const std::size_t texel = level.first_texel + static_cast<std::size_t>(y) * level.width + x;
  const float* row = &factors_[(texel * viewCount() + view.view) * sum.size()];
  for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += weight * row[k];
}

void PatchLookup::factorsAt(const SeenPoint& point, double pixel_angle, std::span<float> factors) const {
  const RttLevels levels =
      rttLevelsAt(rttLevelOf(point.distance, pixel_angle, point.to_eye.z(), texel_width_), levels_.size());
  std::fill(factors.begin(), factors.end(), 0.0F);
  const formats::RttLevel& fine = levels_[levels.fine];
  for (const View& view : viewsAt(fine, placeOf(point.texcoord), point.to_eye)) {
    if (view.weight <= 0) continue;
    add(fine, view, view.weight * (1 - levels.blend), factors);
    if (levels.blend > 0) add(levels_[levels.fine + 1], view, view.weight * levels.blend, factors);
  }
}

}  // namespace bakelight::transport
