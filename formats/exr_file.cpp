#include "formats/exr_file.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfTestFile.h>
#include <OpenEXR/ImfThreading.h>

#include <exception>
#include <new>
#include <string>
#include <thread>

#include "formats/image_checks.h"

namespace bakelight::formats {

// Blocks of scan lines are (de)compressed on all cores where that pays.
namespace {
constexpr std::size_t kManyValues = 1 << 20;
}  // namespace

int exrThreadsFor(std::size_t values) {
  if (values < kManyValues) return 0;
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  if (Imf::globalThreadCount() < threads) Imf::setGlobalThreadCount(threads);
  return threads;
}

bool isPlainExr(const Imf::Header& header) {
  if (header.hasType() && Imf::isDeepData(header.type())) return false;
  if (header.dataWindow() != header.displayWindow() || header.find("Orientation") != header.end())
    return false;
  const Imf::ChannelList& channels = header.channels();
  for (auto it = channels.begin(); it != channels.end(); ++it)
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) return false;
  return channels.begin() != channels.end();
}

std::unique_ptr<Imf::MultiPartInputFile> openPlainExr(const std::filesystem::path& path, std::size_t values) {
  const auto fail = [&](const std::string& problem) {
    return badInput({path.string(), "", ""}, problem, "an OpenEXR file of one flat part");
  };
  if (!std::filesystem::is_regular_file(path)) throw fail("there is no such file");
  if (!Imf::isOpenExrFile(path.c_str())) throw fail("it is no OpenEXR file");
  try {
    auto file = std::make_unique<Imf::MultiPartInputFile>(path.c_str(), exrThreadsFor(values));
    if (file->parts() == 1 && isPlainExr(file->header(0))) return file;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw unreadableImage(path.string(), error.what());
  }
  throw fail("it has several parts, is deep, subsampled, turned, or does not fill its frame");
}

}  // namespace bakelight::formats
