#include "formats/btf_reflection.h"

#include "formats/pixel_transfer.h"

namespace bakelight::formats {

void BtfReflection::describe(FieldVisitor& fields) {
  constexpr std::size_t kMostComponents = 1024;
  fields.constant("frame", "local");
  fields.constant("albedo", "inside");
  fields.integer("lights", lights, {1, kMostLocalSide});
  fields.number("error", error, {.least = 0});
  fields.number("storageRatio", storage_ratio, {.least = 0});
  describePatch(fields, cells(), kMostComponents);
}

}  // namespace bakelight::formats
