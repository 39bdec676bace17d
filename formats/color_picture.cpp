#include "formats/color_picture.h"

#include <array>
#include <new>
#include <optional>

#include "formats/exr_image.h"
#include "formats/image_checks.h"
#include "formats/picture_module.h"

namespace bakelight::formats {
namespace {

// Of an ordinary OpenEXR file whose channels of no layer are red, green and blue, whatever else it has.
std::optional<Image> plainColor(const std::filesystem::path& path) {
  std::optional<Image> all = readPlainExr(path);
  if (!all) return std::nullopt;
  const std::array<int, 3> channels = {all->channelIndex("R"), all->channelIndex("G"),
                                       all->channelIndex("B")};
  for (const int channel : channels)
    if (channel < 0) return std::nullopt;
  if (all->channelCount() == 3 && channels == std::array{0, 1, 2}) return all;
  Image image(all->width, all->height, {"R", "G", "B"});
  for (std::size_t texel = 0; 3 * texel < image.values.size(); ++texel)
    for (std::size_t c = 0; c < 3; ++c)
      image.values[3 * texel + c] =
          all->values[texel * all->channelCount() + static_cast<std::size_t>(channels[c])];
  return image;
}

}  // namespace

ColorPicture readColorPicture(const std::filesystem::path& path, PictureUse use, PictureTurn turn) {
  try {
    std::optional<Image> plain = plainColor(path);
    if (!plain) return pictureReaders().read_color_picture(path, use, turn);
    requireFinite(*plain, path.string());
    ColorPicture picture;
    picture.image = std::move(*plain);
    if (use == PictureUse::kLight)
      if (const std::string note = noteIfBlack(picture.image, path.string()); !note.empty())
        picture.notes.push_back(note);
    return picture;
  } catch (const std::bad_alloc&) {
    throw tooLargeImage(path.string());
  }
}

ColorPicture readColorPicture(std::span<const std::byte> bytes, const std::string& name, PictureUse use,
                              PictureTurn turn) {
  try {
    return pictureReaders().read_color_picture_bytes(bytes, name, use, turn);
  } catch (const std::bad_alloc&) {
    throw tooLargeImage(name);
  }
}

}  // namespace bakelight::formats
