// compare: how far two files of one kind are apart. `bakelight baseline check` asks it, so that the driver
// itself need not load the libraries of every format.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/compare.h"
#include "tools/stage/stage.h"

using namespace bakelight;

namespace {

std::vector<std::string> wordsOf(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), std::istream_iterator<std::string>()};
}

formats::Json toJson(const formats::Difference& difference) {
  return {{"what", difference.what}, {"measured", difference.measured}, {"limit", difference.limit}};
}

}  // namespace

int main(int argc, char** argv) {
  std::filesystem::path file, reference;
  std::string kind = "image", ignored_keys;
  formats::CompareLimits limits;
  stage::Tool tool("compare", "Measures how far two files of the same kind are apart; the stats say it.");
  tool.input("file", "any", file, "What to compare")
      .input("reference", "any", reference, "What relative figures refer to")
      .parameter("kind", kind, formats::comparedKinds(), "What both files are")
      .parameter("distance", limits.distance, {0, 1e300}, "",
                 "mesh, pack: largest distance between vertices, over the bounding box's diagonal")
      .parameter("normal", limits.normal, {0, 2}, "", "mesh, pack: largest difference of two normals")
      .parameter("maximum", limits.maximum, {0, 1e300}, "",
                 "image, tensors, pack: largest difference of two values")
      .parameter("rms", limits.rms, {0, 1e300}, "", "image: root mean square difference of a channel")
      .parameter("relative", limits.relative, {0, 1e300}, "",
                 "tensors, pack, json: difference over the reference, in the norm")
      .parameter("ignored_keys", ignored_keys, {},
                 "tensors, json: names that are left out, separated by spaces");
  return tool.run(argc, argv, [&](stage::Run& run) {
    limits.ignored_keys = wordsOf(ignored_keys);
    const formats::Comparison comparison = formats::compareFiles(kind, file, reference, limits);
    formats::Json differences = formats::Json::array();
    for (const formats::Difference& difference : comparison.differences)
      differences.push_back(toJson(difference));
    run.stat("passes", comparison.passes());
    run.stat("compared_values", comparison.compared_values);
    run.stat("differences", std::move(differences));
    run.stat("mismatches", comparison.mismatches);
  });
}
