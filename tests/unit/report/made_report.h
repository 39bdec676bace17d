// A plan made by code, with packs in closed form and pictures of the finest of them as references, in memory
// or as files.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "formats/image.h"
#include "formats/pack_contents.h"
#include "tools/report/plan.h"
#include "tools/report/sources.h"

namespace bakelight::tests {

struct MadeFrame {
  int width_px = 96, height_px = 72;
  double object_yaw_deg = 0;
  double noise = 0.01;  // standard error of each reference pixel, absolute
};

class MadeReport {
 public:
  // Two views, "sky front" and "soft side": a sky with a sun, and the default light. References show `truth`.
  MadeReport(const formats::Pack& truth, const MadeFrame& frame = {});

  // Parameters as in a sweep; stages with bake times that follow the order. `chain` as in the plan.
  formats::Json& addVariant(const std::string& name, formats::Json parameters, const formats::Pack& pack,
                            formats::Json chain = formats::Json::array());
  // The plan's entry for a file with this pack.
  formats::Json addPack(const std::string& name, const formats::Pack& pack);
  // Plan entries, one a view: pictures of the pack, without noise.
  formats::Json addReferences(const std::string& name, const formats::Pack& pack);

  report::Plan plan() const;
  report::Sources sources() const;  // refers to this
  // All files into `folder`; the path of plan.json.
  std::filesystem::path write(const std::filesystem::path& folder) const;

  formats::Json json;
  std::map<std::string, formats::Pack> packs;
  std::map<std::string, formats::Image> images;
  std::map<std::string, std::map<std::string, std::string>> metadata;

 private:
  formats::Json addPicture(const std::string& name, const formats::Pack& pack, std::size_t view,
                           double noise);
};

// A glossy body with its own colours, of light of that order: the higher the order, the nearer to the truth.
formats::Pack madeGlossyPack(int order, int rings = 20);

}  // namespace bakelight::tests
