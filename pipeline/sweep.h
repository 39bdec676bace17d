// Many variants of one asset, and all that it takes to measure them: path-traced references, and packs that
// differ from a variant's in one respect, so that its error can be split into causes.
//
// The recipe's section "report" says how (docs/REPORT.md):
//   "pack", "frame"      what is measured: a stage's output; the stage that draws it with OpenGL
//   "vary"               what varies unless somebody says it
//   "frame_parameters"   of every picture; "cameras": by name, further parameters of the picture
//   "reference"          a stage that makes ground truth: tool, inputs and its one output, as other stages
//                        have them; "view.environment", "view.lights" are the light that is looked at, and
//                        "truth.OUTPUT" is the picture that the truth itself does not have
//   "comparison"         what compares the variants: tool, and the names of its outputs' files
//   "truth"              { "set": settings, "reference": parameters }
//   "chain"              list of { "cause", "set", "reference", "inputs" } from the truth to the variant.
//                        Links with "reference" are path-traced on what the variant + set makes of the
//                        reference's inputs, of which the link may add some; the others are packs of the
//                        variant + set.
// asset.json has a section "report", too: "lights" { name: file }, "cameras" and "vary", instead of the
// recipe's.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/json.h"
#include "pipeline/build.h"
#include "pipeline/graph.h"
#include "pipeline/variants.h"

namespace bakelight::pipeline {

// One light seen by one camera.
struct View {
  std::string name, light, camera;                      // "studio-front", "studio", "front"
  std::filesystem::path environment = {}, lights = {};  // either may be empty
  formats::Json windowing = {};                   // of the player, or "measured"; null: as the lights say
  formats::Json frame = formats::Json::object();  // parameters of the picture
};

// One picture a view, each differing from the link before in one cause: path-traced, or of a pack.
struct Link {
  std::string cause;
  std::vector<TaskIndex> references;  // by view; empty: a pack
  TaskIndex pack = 0;
};

struct SweptVariant {
  Variant variant;
  TaskIndex pack = 0;
  std::optional<TaskIndex> frame;  // the player's picture, for its times
  std::vector<Link> chain;         // ends with the variant with nothing left out by measurement
};

// What compares the variants.
struct Comparison {
  std::string tool;
  std::string plan_input;                    // port that takes the plan
  std::string figures_output;                // port of the figures, which budgets choose by
  std::map<std::string, std::string> files;  // names by output
};

struct Sweep {
  Graph graph;  // assets are variants, and what they are compared with; equal ones are one
  std::vector<View> views;
  std::vector<TaskIndex> truths;  // references, by view
  std::vector<SweptVariant> variants;
  std::string pack_output, reference_output;  // ports
  Comparison comparison;
};

struct SweepOptions {
  std::vector<std::string> vary = {};  // instead of the asset's or the recipe's
  std::vector<Setting> settings = {};  // for all variants
};

// `asset` with what its recipe and itself say, checked whole. Every mistake is put into `problems`.
Sweep planSweep(const Asset& asset, RecipeBook& recipes, Toolbox& tools, const SweepOptions& options,
                Problems& problems);

// What compares the variants reads: every picture and pack by path and hash, and what each variant cost. Variants
// that failed are listed with the reason; a chain with a failed link is empty.
formats::Json reportPlan(const std::string& asset, const Sweep& sweep, const std::vector<Outcome>& outcomes,
                         Memo& memo);

}  // namespace bakelight::pipeline
