// What a report is made of: views with their references, and variants with their packs (docs/REPORT.md has
// the keys). The driver writes it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/frame_settings.h"
#include "formats/json.h"
#include "formats/triangle_mesh.h"
#include "tools/report/timing.h"

namespace bakelight::report {

// Files of one hash have the same content.
struct PlanFile {
  std::filesystem::path path;
  std::string hash;
};

struct PlanView {
  std::string name, light, camera;
  std::filesystem::path environment_path, lights_path;  // as formats::readLights; may be empty
  std::optional<double> windowing;                      // of formats::readLights
  bool windows_measured = false;  // for each pack that of least error (window.h); `windowing` is then 0
  formats::FrameSettings frame;
  formats::Float3 ground_albedo = {0.5F, 0.5F,
                                   0.5F};  // where a pack has a ground, and the reference shows it
  PlanFile reference;
};

struct StageFigures {
  std::string stage;
  double wall_s = 0, cpu_s = 0;
  std::uint64_t peak_memory_bytes = 0, bytes = 0;  // bytes: of its outputs
  std::vector<std::string> warnings;
};

// What a measured figure made unnecessary.
struct LeftOut {
  std::string stage, what, figure;
  double value = 0, threshold = 0;
  std::optional<double> error;  // that was expected of it
};

// A step from the truth to the variant's pack that switches one cause of error on.
struct ChainLink {
  std::string cause;                 // "simplification", "sh_truncation", …: the recipe's word
  std::vector<PlanFile> references;  // one a view; or none, and then
  PlanFile pack;
};

// As the player measured them: by the CPU's clock until OpenGL had finished, and by the GPU's own where the
// player told it.
struct GlTimes {
  Spread light_change_ms, frame_ms;
  std::optional<Spread> gpu_light_change_ms, gpu_frame_ms;
};

struct PlanVariant {
  std::string name;
  formats::Json parameters;  // "stage.parameter": value
  PlanFile pack;
  std::vector<StageFigures> stages;
  std::vector<LeftOut> left_out;
  std::optional<GlTimes> gl;
  std::vector<ChainLink> chain;
};

struct FailedVariant {
  std::string name, stage, reason;
};

struct Plan {
  std::string asset;
  std::vector<PlanView> views;        // at least one
  std::vector<PlanVariant> variants;  // at least one; no two of one name
  std::vector<FailedVariant> failed;
};

// Throws Error(kBadInput) naming `file` and JSON pointer. Files are not opened.
Plan planFromJson(const formats::Json& json, const std::string& file);

}  // namespace bakelight::report
