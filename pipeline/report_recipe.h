// A recipe's section "report", checked as far as the driver reads it (see pipeline/sweep.h).
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/json.h"
#include "formats/json_reader.h"
#include "pipeline/asset.h"
#include "pipeline/problems.h"
#include "pipeline/recipe.h"
#include "pipeline/sweep.h"
#include "pipeline/toolbox.h"

namespace bakelight::pipeline {

class ReportRecipe {
 public:
  // What wires of a reference begin with, besides stages and "asset": the light that is looked at, and the
  // picture that the truth itself does not have.
  static constexpr const char* kView = "view";
  static constexpr const char* kTruth = "truth";

  struct Link {
    std::string cause;
    std::vector<Setting> settings;
    std::optional<formats::Json> reference;  // parameters; values may be { "same_as": "stage.parameter" }
    std::map<std::string, Wire> inputs;      // of the reference, besides those that all have
  };

  // How ground truth is made.
  struct Reference {
    std::string tool;
    std::map<std::string, Wire> inputs;
    std::string output, file;
  };

  // Keeps a reference to `recipe`. Throws Error(kBadInput) if it has no such section; so do all that follow,
  // for what is not there or wrong.
  ReportRecipe(const Recipe& recipe, Problems& problems);

  Wire pack() const;
  std::string frameStage() const;  // "" if there is none
  std::vector<std::string> vary() const;
  formats::JsonReader cameras() const;
  formats::Json frameParameters() const;
  Reference reference(Problems& problems) const;
  Comparison comparison(Toolbox& tools, Problems& problems) const;
  Link truth() const;
  std::vector<Link> chain(Problems& problems) const;

 private:
  std::map<std::string, Wire> inputsOf(const formats::JsonReader& object) const;
  Link link(const formats::JsonReader& object, const std::string& cause) const;

  const Recipe& recipe_;
  formats::JsonReader object_;
};

}  // namespace bakelight::pipeline
