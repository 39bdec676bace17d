// Neighborhood transfer (Sloan, Kautz & Snyder 2002, section 8): what an object does to the light around it, as a part of a pack. Both
// tables hold the difference that the object makes, which is 0 where it is not seen.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "formats/encoded_table.h"
#include "formats/fields.h"

namespace bakelight::formats {

// Coefficients of incident radiance that a diffuse receiver needs: bands 0, 1, 2 and 4, l(l+1)+m each. The clamped cosine has no band 3,
// and little beyond (Ramamoorthi & Hanrahan 2001).
inline constexpr int kReceivedCoefficients = 18;
constexpr int receivedCoefficient(int index) {
  return index < 9 ? index : index + 7;
}

// Points of the plane that the object stands on, x fastest: a rectilinear grid in the object's space, its normal +y.
struct GroundTransfer {
  float level = 0;          // y of the plane
  std::vector<float> x, z;  // coordinates of the points, rising
  // (x · z) × (channels · order²). Irradiance at a point, divided by π, is that of the open plane plus Σ_i vectors[i] · light[i].
  EncodedTable vectors;
};

// Points of space, x fastest, then y, then z.
struct VolumeTransfer {
  std::array<std::vector<float>, 3> axes;  // coordinates of the points, rising
  // (x · y · z) × (channels · kReceivedCoefficients · order²): incident radiance is the light's own, plus matrix · light.
  EncodedTable matrices;
};

struct Neighborhood {
  static constexpr const char* kKind = "neighborhood";
  void describe(FieldVisitor& fields);

  int order = 0;     // bands of the incident light, 1–10
  int channels = 1;  // or 3, where what the object reflects is coloured
  std::optional<GroundTransfer> ground;
  std::optional<VolumeTransfer> volume;
};

}  // namespace bakelight::formats
