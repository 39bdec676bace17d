// The part of the pack: a picture of a lit ball, by which a body reflects as the ball does where its normal
// is the same to the eye (Sloan, Martin, Gooch & Gooch 2001, "The Lit Sphere").
#pragma once

#include "formats/pack_contents.h"

namespace bakelight::example {

struct NormalReflection {
  static constexpr const char* kKind = "normals";
  void describe(formats::FieldVisitor& fields);

  // R, G, B of a ball seen from far away, +Y upwards, under light of a mean radiance of 1; square, and the
  // ball touches its edges.
  formats::PackImage picture;
};

// The one reflection of a pack, or null: what both techniques go by.
const NormalReflection* normalReflectionOf(const formats::Pack& pack);

}  // namespace bakelight::example
