// How the parts of a pack tell their fields: once, to whoever asks. The writer, the reader, the checker, the
// comparer, the permuter of vertices and `inspect` are visitors of one list each part has, so that none of
// them can forget a field that another one knows.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/pack_image.h"
#include "formats/shared_bytes.h"
#include "formats/triangle_mesh.h"
#include "formats/words.h"

namespace bakelight::formats {

// Inclusive; without `above`, `least` itself is allowed.
struct Range {
  double least = std::numeric_limits<double>::lowest(), greatest = std::numeric_limits<double>::max();
  bool above = false;

  // False for NaN, too.
  bool holds(double value) const { return (above ? value > least : value >= least) && value <= greatest; }
};
const char* nameOfIntegers(std::size_t width);  // "uint8", "uint16", "uint32"
std::string textOf(const Range& range);         // "0 to 1", "above 0", "0 or more", "a finite number"

// What the rows of a table or list belong to: with one a vertex they follow the vertices when these are
// reordered, and must be as many.
enum class Rows { kVertex, kOther };

// Unsigned integers as they are stored, little-endian.
struct IntegerArray {
  std::size_t width = 1;  // bytes of each: 1, 2 or 4
  SharedBytes data;

  std::size_t count() const { return data.size() / width; }
};

// Names are the keys in the pack's JSON, and of the sections that hold bytes. Values are read and written:
// a visitor that only looks leaves them as they are. A field's shape may depend on fields before it.
class FieldVisitor {
 public:
  virtual ~FieldVisitor() = default;

  virtual void integer(const char* name, int& value, const Range& range) = 0;
  virtual void number(const char* name, float& value, const Range& range) = 0;
  virtual void vector(const char* name, Float3& value, const Range& range) = 0;  // of each component
  // What is always the same, told so that other readers need not guess.
  virtual void constant(const char* name, const char* text) = 0;
  // An index into `names`; beyond them for a value that has none.
  virtual void choice(const char* name, int& value, std::span<const char* const> names) = 0;

  // rows × columns; any number of rows with Rows::kOther.
  virtual void table(const char* name, EncodedTable& table, Rows rows, std::size_t columns) = 0;
  // `count` finite values.
  virtual void floats(const char* name, std::vector<float>& values, std::size_t count) = 0;
  // `count` of them, of the width that the array has; nothing of a vertex.
  virtual void integers(const char* name, IntegerArray& values, std::size_t count) = 0;
  // One a vertex, each below `end`; stored in 1, 2 or 4 bytes, as `end` asks for.
  virtual void indices(const char* name, std::vector<std::uint32_t>& values, std::size_t end) = 0;
  // glTF's TANGENT: one a vertex, unit, at right angles to the normal; w = 1 or −1.
  virtual void tangents(const char* name, std::vector<Float4>& values) = 0;
  virtual void image(const char* name, PackImage& image) = 0;

  // Opens what is grouped under a name if it is there; a reader may answer otherwise than `is_there`. Only
  // after true, fields follow, and close().
  virtual bool open(const char* name, bool is_there) = 0;
  virtual void close() = 0;

  // A rule between fields, for those who judge: `what` is wrong with the field unless it holds.
  virtual void require(bool holds, const char* name, const std::string& what, const std::string& expected,
                       const std::string& remedy) = 0;
};

template <class Value, std::size_t N>
void choose(FieldVisitor& fields, const char* name, Value& value, const Word<Value> (&words)[N]) {
  const char* names[N];
  int index = static_cast<int>(N);  // what has no word is for the visitor to refuse
  for (std::size_t i = 0; i < N; ++i) {
    names[i] = words[i].text;
    if (words[i].value == value) index = static_cast<int>(i);
  }
  fields.choice(name, index, names);
  if (index >= 0 && index < static_cast<int>(N)) value = words[index].value;
}

// A group that may be missing; `describe` tells its fields.
template <class Group, class Describe>
void optionally(FieldVisitor& fields, const char* name, std::optional<Group>& group,
                const Describe& describe) {
  if (!fields.open(name, group.has_value())) return;
  if (!group) group.emplace();
  describe(*group);
  fields.close();
}

}  // namespace bakelight::formats
