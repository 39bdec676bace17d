#include "formats/neighborhood.h"

#include <algorithm>
#include <string>

namespace bakelight::formats {
namespace {

constexpr double kMostPoints = 4096;  // along an axis
constexpr double kMaxOrder = 10;

void describeAxis(FieldVisitor& fields, const char* count_name, const char* name, std::vector<float>& axis) {
  int count = static_cast<int>(axis.size());
  fields.integer(count_name, count, {2, kMostPoints});
  fields.floats(name, axis, static_cast<std::size_t>(count));
  fields.require(
      std::adjacent_find(axis.begin(), axis.end(), [](float a, float b) { return !(a < b); }) == axis.end(),
      name, "its coordinates do not rise", "each above the one before", "bake the neighborhood again");
}

void requireRows(FieldVisitor& fields, const char* name, const EncodedTable& table, std::size_t points) {
  fields.require(table.rows == points, name, "it has " + std::to_string(table.rows) + " rows",
                 std::to_string(points) + ", one a point", "bake the neighborhood again");
}

}  // namespace

void Neighborhood::describe(FieldVisitor& fields) {
  fields.constant("basis", "real_sh_cartesian");
  fields.constant("frame", "object");
  fields.integer("order", order, {1, kMaxOrder});
  fields.integer("channels", channels, {1, 3});
  fields.require(channels != 2, "channels", "it has 2 channels", "1 or 3", "");
  const auto values =
      static_cast<std::size_t>(channels) * static_cast<std::size_t>(order) * static_cast<std::size_t>(order);
  optionally(fields, "ground", ground, [&](GroundTransfer& plane) {
    fields.number("level", plane.level, {});
    describeAxis(fields, "countX", "groundX", plane.x);
    describeAxis(fields, "countZ", "groundZ", plane.z);
    fields.table("groundVectors", plane.vectors, Rows::kOther, values);
    requireRows(fields, "groundVectors", plane.vectors, plane.x.size() * plane.z.size());
  });
  optionally(fields, "volume", volume, [&](VolumeTransfer& space) {
    describeAxis(fields, "countX", "volumeX", space.axes[0]);
    describeAxis(fields, "countY", "volumeY", space.axes[1]);
    describeAxis(fields, "countZ", "volumeZ", space.axes[2]);
    fields.table("volumeMatrices", space.matrices, Rows::kOther, kReceivedCoefficients * values);
    requireRows(fields, "volumeMatrices", space.matrices,
                space.axes[0].size() * space.axes[1].size() * space.axes[2].size());
  });
  fields.require(ground || volume, "ground", "there is neither ground nor volume", "one of them, or both",
                 "");
}

}  // namespace bakelight::formats
