// Where a frame is drawn: linear float subsamples with depth, and the resolve pass that makes the picture of
// them.
#pragma once

#include "formats/image.h"
#include "tools/player/gl/gl_objects.h"

namespace bakelight::player {

enum class PictureEncoding {
  kDisplay,  // exposed and sRGB-encoded, values k/255, colour not premultiplied: for PNG
  kLinear,   // linear radiance without exposure, colour premultiplied by coverage: for OpenEXR
};

// A resolved picture that is not a window's.
class ResolvedPicture {
 public:
  ResolvedPicture(PictureEncoding encoding, int width_px, int height_px);

  PictureEncoding encoding() const { return encoding_; }
  GLuint framebuffer() const { return framebuffer_.name(); }
  formats::Image read() const;  // R, G, B, A

 private:
  PictureEncoding encoding_;
  int width_px_, height_px_;
  Texture texture_;
  Framebuffer framebuffer_;
};

class PictureTarget {
 public:
  PictureTarget();

  // Makes storage for width × height pixels of supersampling² subsamples, unless it is there already. Throws
  // Error(kBadInput) if this GL has no textures of that size, Error(kNotAvailable) if it is out of memory.
  void resize(int width_px, int height_px, int supersampling);

  // The framebuffer to draw subsamples into, cleared and bound, viewport set.
  void beginFrame(float background_alpha);

  // Box filter, exposure and sRGB into `framebuffer` (0: the window) of the current size. The subsamples
  // stay.
  void resolveForDisplay(GLuint framebuffer, float exposure) const;

  // Into a picture of the current size, by its encoding.
  void resolve(const ResolvedPicture& picture, float exposure) const;
  // The same as an image of PictureEncoding::kDisplay, or kLinear.
  formats::Image displayImage(float exposure) const;
  formats::Image linearImage() const;

  int widthPx() const { return width_px_; }
  int heightPx() const { return height_px_; }
  int supersampling() const { return supersampling_; }

 private:
  void resolve(GLuint framebuffer, float exposure, bool display_encoded) const;

  int width_px_ = 0, height_px_ = 0, supersampling_ = 0;
  Program resolve_program_;
  VertexArray no_attributes_;
  Texture subsamples_, depth_;
  Framebuffer framebuffer_;
};

}  // namespace bakelight::player
