// Display encoding, the same arithmetic as in the player's shader.
#pragma once

namespace bakelight::transport {

// Linear → sRGB (IEC 61966-2-1), input clamped to [0, 1]; NaN gives 0.
float srgbFromLinear(float linear);
// sRGB → linear, input clamped to [0, 1].
float linearFromSrgb(float srgb);
// The 8-bit code nearest to the encoded value.
int displayCode(float linear);

}  // namespace bakelight::transport
