#include "tools/player/surroundings/surroundings.h"

#include <algorithm>
#include <stdexcept>

#include "formats/neighborhood.h"

namespace bakelight::player {
namespace {

const formats::Neighborhood* neighborhoodOf(const formats::Pack& pack) {
  return pack.neighborhood ? pack.neighborhood->as<formats::Neighborhood>() : nullptr;
}

}  // namespace

int neighborhoodOrder(const formats::Pack& pack) {
  const formats::Neighborhood* neighborhood = neighborhoodOf(pack);
  return neighborhood == nullptr ? 0 : neighborhood->order;
}

Surroundings::Surroundings(const formats::Pack& pack, const SurroundingsOptions& options,
                           const transport::BoundingSphere& object, bool near_light)
    : options_(options), light_(near_light) {
  const formats::Neighborhood* neighborhood = neighborhoodOf(pack);
  if (options_.receiver && (neighborhood == nullptr || !neighborhood->volume))
    throw std::invalid_argument("the pack has no volume for a receiver");
  if (neighborhood == nullptr) return;
  if (neighborhood->ground && options_.ground != ShownGround::kOff)
    ground_.emplace(*neighborhood, object.center, options_.ground_albedo);
  if (options_.receiver) receiver_.emplace(*neighborhood, *options_.receiver, object);
}

void Surroundings::setLight(const GpuLight& distant, const GpuLight* near) {
  if ((!ground_ && !receiver_) || !light_.update(distant, near)) return;
  if (ground_) ground_->setLight(light_.sh());
  if (receiver_) receiver_->setLight(light_.sh());
}

void Surroundings::place(const Eigen::Matrix3d& world_from_object, double time_s) {
  if (receiver_) receiver_->place(world_from_object, time_s);
}

void Surroundings::drawReceiver(const Eigen::Matrix4d& clip_from_centered) const {
  if (receiver_) receiver_->draw(clip_from_centered);
}

void Surroundings::drawGround(const Eigen::Matrix4d& clip_from_centered,
                              const Eigen::Matrix3d& world_from_object, bool transparent) const {
  if (!ground_ || (options_.ground == ShownGround::kAuto && transparent)) return;
  ground_->draw((clip_from_centered * Eigen::Affine3d(world_from_object).matrix()).cast<float>());
}

double Surroundings::radius() const {
  return std::max(ground_ ? ground_->radius() : 0, receiver_ ? receiver_->reach() : 0);
}

std::size_t Surroundings::gpuBytes() const {
  return (ground_ ? ground_->gpuBytes() : 0) + (receiver_ ? receiver_->gpuBytes() : 0) + light_.gpuBytes();
}

}  // namespace bakelight::player
