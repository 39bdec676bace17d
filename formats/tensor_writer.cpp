#include "formats/tensor_writer.h"

#include <stdexcept>

namespace bakelight::formats {

TensorWriter::TensorWriter(const std::filesystem::path& path,
                           const std::map<std::string, TensorShape>& tensors,
                           const std::map<std::string, std::string>& metadata)
    : file_(path) {
  const TensorLayout layout = layOutTensors(tensors, metadata);
  file_.writeAt(0, layout.header);
  for (const auto& [name, bytes] : layout.places)
    places_[name] = {sizeOf(tensors.at(name).type), layout.header.size() + bytes.begin,
                     layout.header.size() + bytes.end};
}

void TensorWriter::appendBytes(const std::string& name, std::size_t element_size,
                               std::span<const std::byte> bytes) {
  const auto place = places_.find(name);
  if (place == places_.end()) throw std::logic_error("there is no tensor " + name);
  if (element_size != 1 && element_size != place->second.element_size)
    throw std::logic_error("tensor " + name + ": values of another size");
  if (bytes.size() > place->second.end - place->second.next)
    throw std::logic_error("tensor " + name + ": more values than its shape holds");
  file_.writeAt(place->second.next, bytes);
  place->second.next += bytes.size();
}

void TensorWriter::finish() {
  for (const auto& [name, place] : places_)
    if (place.next != place.end) throw std::logic_error("tensor " + name + ": values are missing");
  file_.finish();
}

}  // namespace bakelight::formats
