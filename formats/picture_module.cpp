#include "formats/picture_module.h"

#include "formats/module.h"

namespace bakelight::formats {

const PictureReaders& pictureReaders() {
  static const auto* readers =
      static_cast<const PictureReaders*>(moduleEntry("pictures", "bakelight_picture_readers"));
  return *readers;
}

}  // namespace bakelight::formats
