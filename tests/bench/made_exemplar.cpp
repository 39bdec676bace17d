// made_exemplar NAME FILE.png: a texture of tests/support/exemplars.h as a picture to run tools on.
#include <functional>
#include <iostream>
#include <map>
#include <string>

#include "formats/error.h"
#include "formats/image.h"
#include "tests/support/exemplars.h"
#include "transport/color.h"

int main(int argc, char** argv) {
  using namespace bakelight;
  const std::map<std::string, std::function<formats::Image()>> exemplars = {
      {"weave", [] { return tests::weave(); }},
      {"stones", [] { return tests::stones(); }},
      {"stochastic", [] { return tests::stochastic(); }}};
  const auto chosen = exemplars.find(argc == 3 ? argv[1] : "");
  if (chosen == exemplars.end()) {
    std::cerr << "usage: made_exemplar weave|stones|stochastic FILE.png\n";
    return static_cast<int>(ExitStatus::kUsage);
  }
  try {
    const formats::Image image = chosen->second();
    formats::Image picture(image.width, image.height, {"R", "G", "B"});
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          picture.texel(x, y)[c] = transport::srgbFromLinear(image.texel(x, y)[c]);
    formats::writePng(argv[2], picture);
  } catch (const Error& error) {
    std::cerr << "made_exemplar: " << error.paragraph() << '\n';
    return static_cast<int>(error.status());
  }
}
