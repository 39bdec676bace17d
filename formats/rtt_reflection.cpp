#include "formats/rtt_reflection.h"

#include "formats/pack_contents.h"

namespace bakelight::formats {

void RttReflection::describe(FieldVisitor& fields) {
  constexpr std::size_t kMostComponents = std::size_t{3} * kMaxOrder * kMaxOrder;
  fields.constant("frame", "local");
  fields.constant("albedo", "inside");
  fields.integer("order", order, {1, kMaxOrder});
  describePatch(fields, static_cast<std::size_t>(order) * order, kMostComponents);
}

}  // namespace bakelight::formats
