// The fields of a part as a flat list, for whoever shows or compares them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/fields.h"
#include "formats/json.h"
#include "formats/pack_part.h"

namespace bakelight::formats {

// One of these; pointers are into the part.
struct FieldValue {
  std::string name;  // "nearField.radius"
  Json plain = {};   // a number, text, list of numbers or of indices; null for what follows
  const EncodedTable* table = nullptr;
  const IntegerArray* integers = nullptr;
  std::vector<float> values = {};  // floats, or the components of tangents
  bool isPlain() const { return !plain.is_null(); }
};

std::vector<FieldValue> fieldsOf(const PackPart& part);

}  // namespace bakelight::formats
