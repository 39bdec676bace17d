// A point of the surface, as the way from it to another one is asked for.
#pragma once

#include "transport/medium_field.h"
#include "transport/vector_types.h"

namespace bakelight::kernels {

using transport::Vec3;
using Surroundings = transport::MediumField::Surroundings;

struct Point {
  Vec3 position;
  const Surroundings* around = nullptr;  // where the field is of the surface; else not looked at
};

}  // namespace bakelight::kernels
