#include "formats/oiio_image.h"
#include "formats/picture_module.h"

extern "C" const void* bakelight_picture_readers() {
  namespace oiio = bakelight::formats::oiio;
  static constexpr bakelight::formats::PictureReaders kReaders = {
      oiio::readImage, oiio::readImageMetadata, oiio::readColorPicture, oiio::readColorPicture};
  return &kReaders;
}
