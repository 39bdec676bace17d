#include "formats/pack_contents.h"

#include <stdexcept>

namespace bakelight::formats {

const char* nameOf(MatrixStorage storage) {
  switch (storage) {
    case MatrixStorage::kNone:
      return "none";
    case MatrixStorage::kMatrix:
      return "matrix";
    case MatrixStorage::kVisibility:
      return "visibility";
    case MatrixStorage::kCpca:
      return "cpca";
  }
  throw std::logic_error("a storage without a name");
}

const char* nameOf(LobeModel model) {
  switch (model) {
    case LobeModel::kNone:
      return "none";
    case LobeModel::kPhong:
      return "phong";
    case LobeModel::kGgx:
      return "ggx";
    case LobeModel::kTable:
      return "table";
  }
  throw std::logic_error("a lobe without a name");
}

}  // namespace bakelight::formats
