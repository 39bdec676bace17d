// Distant light as SH coefficients, RGB: order² entries of linear radiance.
#pragma once

#include <span>
#include <vector>

#include "formats/image.h"
#include "transport/sh.h"

namespace bakelight::transport {

using ShLight = std::vector<Float3>;

// Lat-long orientation (that of OpenEXR's environment maps): +Y is the top row; the centre column looks along
// +Z, the left and right edges along −Z, a quarter from the left is +X. So an image is seen unmirrored from
// inside.
Vec3 directionOfLatLong(double u, double v);  // u, v in [0, 1], v = 0 at the top row's upper edge
std::array<double, 2> latLongOfDirection(const Vec3& direction);
// Steradians that a texel of row `row` covers, exact: Δφ (sin of its upper − sin of its lower latitude).
double latLongTexelSolidAngle(int row, int width, int height);

// L_i = ∫ L(s) y_i(s) ds; each texel weighs its exact solid angle, with the basis at its centre. Takes the
// channels R, G, B (or one channel for all three) whatever layer prefix they carry. Throws Error(kBadInput)
// naming `file` if the image is not twice as wide as high or has no such channels. Cost: texels × order²
// multiply-adds, on all TBB threads.
ShLight projectLatLong(const formats::Image& image, int order, const std::string& file);

// The image's light with exactly the channels R, G, B; names and errors as for projectLatLong.
formats::Image rgbImage(const formats::Image& image, const std::string& file);

// From the sums over parts of an image ([colour · order² + i] each), added up in their order, so that the
// same bytes come whatever the threads that made them.
ShLight lightFromParts(std::span<const std::vector<double>> parts, int order);

// Radiance towards `direction`, bilinear across texel centres, wrapping around in longitude.
Float3 lookUpLatLong(const formats::Image& image, const Vec3& direction);

// A uniform disk of half angle `half_angle_rad` around `axis` (towards the light).
ShLight diskLight(int order, const Vec3& axis, double half_angle_rad, const Float3& radiance);
ShLight uniformLight(int order, const Float3& radiance);
// Light from one direction that gives a surface facing it `irradiance`: L_i = E y_i(direction).
ShLight directionalLight(int order, const Vec3& direction, const Float3& irradiance);
// A uniform polygon, exact to rounding: see polygonSh in transport/polygon_light.h.
ShLight polygonLight(int order, std::span<const Vec3> vertices, const Float3& radiance);

ShLight sum(const ShLight& a, const ShLight& b);
// Each coefficient times `factor`.
ShLight scaled(const ShLight& light, double factor);
// Of linear RGB with the primaries of sRGB (Rec. 709).
double luminance(const Float3& rgb);

// The light of a scene that names none: a soft key from the upper left front over a dim uniform sky.
struct DefaultLight {
  Vec3 key_direction = Vec3(-0.5, 0.7, 0.6).normalized();
  double key_half_angle_rad = 0.6;
  Float3 key_radiance = {2.6f, 2.5f, 2.3f};
  Float3 sky_radiance = {0.25f, 0.28f, 0.33f};  // adds up with the key
};
ShLight defaultLight(int order);

}  // namespace bakelight::transport
