#include "formats/exr_rows.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>

#include "formats/exr_file.h"
#include "formats/image_checks.h"

namespace bakelight::formats {

struct ExrRows::Implementation {
  Implementation(const std::filesystem::path& path, std::vector<std::string> names)
      : file_name(path.string()),
        channels(std::move(names)),
        file(openPlainExr(path, std::numeric_limits<std::size_t>::max())),
        part(*file, 0) {
    for (const std::string& name : channels)
      if (part.header().channels().findChannel(name) == nullptr)
        throw badInput({file_name, "channel " + name, ""}, "there is no such channel");
    window = part.header().dataWindow();
  }

  std::string file_name;
  std::vector<std::string> channels;
  std::unique_ptr<Imf::MultiPartInputFile> file;
  Imf::InputPart part;
  Imath::Box2i window;
};

ExrRows::ExrRows(const std::filesystem::path& path, std::vector<std::string> channels)
    : implementation_(std::make_unique<Implementation>(path, std::move(channels))) {}

ExrRows::~ExrRows() = default;

int ExrRows::width() const {
  return implementation_->window.max.x - implementation_->window.min.x + 1;
}

int ExrRows::height() const {
  return implementation_->window.max.y - implementation_->window.min.y + 1;
}

void ExrRows::read(int first, int count, std::span<float> values) {
  Implementation& own = *implementation_;
  const std::size_t channel_count = own.channels.size(),
                    row = channel_count * static_cast<std::size_t>(width());
  if (first < 0 || count < 1 || first + count > height() ||
      values.size() != row * static_cast<std::size_t>(count))
    throw std::logic_error("rows beyond the image");
  Imath::Box2i rows = own.window;
  rows.min.y += first;
  rows.max.y = rows.min.y + count - 1;
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < channel_count; ++c)
    frame.insert(own.channels[c], Imf::Slice::Make(Imf::FLOAT, values.data() + c, rows,
                                                   channel_count * sizeof(float), row * sizeof(float)));
  try {
    own.part.setFrameBuffer(frame);
    own.part.readPixels(rows.min.y, rows.max.y);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw unreadableImage(own.file_name, error.what());
  }
}

}  // namespace bakelight::formats
