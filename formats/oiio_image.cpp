#include "formats/oiio_image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <algorithm>
#include <memory>
#include <new>
#include <span>

#include "formats/error.h"

namespace bakelight::formats::oiio {
namespace {

Image readWith(OIIO::ImageInput& input, const std::string& file, NonFinite non_finite) {
  const OIIO::ImageSpec& spec = input.spec();
  requireFlat(spec, file);
  Image image(spec.width, spec.height, spec.channelnames);
  if (!input.read_image(0, 0, 0, -1, OIIO::TypeDesc::FLOAT, image.values.data())) {
    throw unreadableImage(file, input.geterror());
  }
  image = upright(std::move(image), input);
  if (non_finite == NonFinite::kReject) requireFinite(image, file);
  return image;
}

// Exif's orientations: how far each axis of the image runs along those of the file.
struct Turn {
  bool transposed = false, mirrored_x = false, mirrored_y = false;  // of the upright image, in this order
};

Turn turnOf(const OIIO::ImageInput& input) {
  int orientation = input.spec().get_int_attribute("Orientation", 1);
  // OpenImageIO numbers two of Radiance's eight the other way round: "+X n +Y m" begins in the lower left
  // and runs upwards, which is Exif's 8; "-X n -Y m" is its 6.
  if (std::string_view(input.format_name()) == "hdr" && (orientation == 6 || orientation == 8))
    orientation = 14 - orientation;
  switch (orientation) {
    case 2:
      return {false, true, false};
    case 3:
      return {false, true, true};
    case 4:
      return {false, false, true};
    case 5:
      return {true, false, false};
    case 6:
      return {true, true, false};
    case 7:
      return {true, true, true};
    case 8:
      return {true, false, true};
    default:
      return {};
  }
}

}  // namespace

OIIO::ImageSpec readingHints(bool converted) {
  OIIO::ImageSpec hints;
  hints["oiio:UnassociatedAlpha"] = 1;  // values as they stand in the file: colour is not multiplied by alpha
  hints["oiio:RawColor"] = converted ? 0 : 1;
  return hints;
}

void requireFlat(const OIIO::ImageSpec& spec, const std::string& file) {
  if (spec.depth > 1 || spec.deep) throw badInput({file, "", ""}, "it is deep or a volume", "a flat image");
  if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
      spec.height != spec.full_height) {
    throw badInput(
        {file, "", ""}, "its data window is not its display window", "an image that fills its frame",
        "fill the frame with oiiotool --croptofull, or drop it with oiiotool --origin +0+0 --fullpixels");
  }
}

std::unique_ptr<OIIO::ImageInput> openImage(const std::string& file, bool converted) {
  if (!std::filesystem::is_regular_file(file))
    throw badInput({file, "", ""}, "there is no such file", "an image");
  const OIIO::ImageSpec hints = readingHints(converted);
  auto input = OIIO::ImageInput::open(file, &hints);
  if (!input) throw unreadableImage(file, OIIO::geterror());
  return input;
}

Image upright(Image image, const OIIO::ImageInput& input) {
  const Turn turn = turnOf(input);
  if (!turn.transposed && !turn.mirrored_x && !turn.mirrored_y) return image;
  Image turned(turn.transposed ? image.height : image.width, turn.transposed ? image.width : image.height,
               image.channel_names);
  for (int y = 0; y < turned.height; ++y)
    for (int x = 0; x < turned.width; ++x) {
      const int across = turn.mirrored_x ? turned.width - 1 - x : x;
      const int down = turn.mirrored_y ? turned.height - 1 - y : y;
      const float* from = turn.transposed ? image.texel(down, across) : image.texel(across, down);
      std::copy(from, from + image.channelCount(), turned.texel(x, y));
    }
  return turned;
}

Image readImage(const std::filesystem::path& path, NonFinite non_finite) {
  const std::string file = path.string();
  return readWith(*openImage(file, false), file, non_finite);
}

std::map<std::string, std::string> readImageMetadata(const std::filesystem::path& path) {
  const auto input = openImage(path.string(), false);
  std::map<std::string, std::string> metadata;
  for (const OIIO::ParamValue& attribute : input->spec().extra_attribs)
    if (attribute.type() == OIIO::TypeString)
      metadata.emplace(attribute.name().string(), attribute.get_string());
  return metadata;
}

}  // namespace bakelight::formats::oiio
