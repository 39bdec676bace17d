#include "formats/index_image.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <memory>
#include <new>

#include "formats/exr_file.h"
#include "formats/exr_image.h"
#include "formats/image_checks.h"

namespace bakelight::formats {

int IndexImage::channelIndex(const std::string& name) const {
  const auto found = std::find(channel_names.begin(), channel_names.end(), name);
  return found == channel_names.end() ? -1 : static_cast<int>(found - channel_names.begin());
}

void writeIndexExr(const std::filesystem::path& path, const IndexImage& image,
                   const std::map<std::string, std::string>& metadata) {
  writeFileAtomically(path, encodedExr(image, metadata));
}

IndexImage readIndexExr(const std::filesystem::path& path, const std::vector<std::string>& channels) {
  const std::unique_ptr<Imf::MultiPartInputFile> file =
      openPlainExr(path, std::numeric_limits<std::size_t>::max());
  Imf::InputPart part(*file, 0);
  for (const std::string& name : channels) {
    const Imf::Channel* channel = part.header().channels().findChannel(name);
    if (channel == nullptr)
      throw badInput({path.string(), "channel " + name, ""}, "there is no such channel");
    if (channel->type != Imf::UINT)
      throw badInput({path.string(), "channel " + name, ""}, "its values are no integers",
                     "32-bit unsigned integers");
  }
  const Imath::Box2i window = part.header().dataWindow();
  IndexImage image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, channels);
  const std::size_t row = channels.size() * static_cast<std::size_t>(image.width);
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < channels.size(); ++c)
    frame.insert(channels[c],
                 Imf::Slice::Make(Imf::UINT, image.values.data() + c, window,
                                  channels.size() * sizeof(std::uint32_t), row * sizeof(std::uint32_t)));
  try {
    part.setFrameBuffer(frame);
    part.readPixels(window.min.y, window.max.y);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw unreadableImage(path.string(), error.what());
  }
  return image;
}

std::vector<std::string> exrChannels(const std::filesystem::path& path) {
  std::vector<std::string> names;
  try {
    const std::unique_ptr<Imf::MultiPartInputFile> file = openPlainExr(path, 0);
    const Imf::ChannelList& channels = file->header(0).channels();
    for (auto it = channels.begin(); it != channels.end(); ++it) names.emplace_back(it.name());
  } catch (const Error&) {
    // It is none.
  }
  return names;
}

}  // namespace bakelight::formats
