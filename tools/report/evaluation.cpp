#include "tools/report/evaluation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "formats/error.h"
#include "tools/report/storage.h"
#include "transport/color.h"

namespace bakelight::report {
namespace {

using transport::Vec3;

// Pictures of so many packs are kept: the links that variants of a sweep share stand near each other.
constexpr std::size_t kKeptPictures = 8;

// "x y z", commas and brackets between them allowed.
std::vector<double> numbersOf(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == ']'; }, ' ');
  std::istringstream stream(text);
  stream.imbue(std::locale::classic());
  std::vector<double> numbers;
  for (double number; stream >> number;) numbers.push_back(number);
  return numbers;
}

std::vector<double> metadataNumbers(const std::map<std::string, std::string>& metadata,
                                    const std::string& key, std::size_t count, const std::string& file) {
  const auto found = metadata.find(key);
  std::vector<double> numbers = found == metadata.end() ? std::vector<double>() : numbersOf(found->second);
  if (numbers.size() != count)
    throw badInput({file, "attribute " + key, ""},
                   found == metadata.end() ? "it is missing" : "\"" + found->second + "\" cannot be read",
                   std::to_string(count) + (count == 1 ? " number" : " numbers"),
                   "rendering the picture with `reference`");
  return numbers;
}

transport::OrbitCamera cameraOf(const PlanView& view, const Sources& sources) {
  const std::string file = view.reference.path.string();
  const auto metadata = sources.image_metadata(view.reference.path);
  const auto eye = metadataNumbers(metadata, "bakelight:eye", 3, file);
  const auto target = metadataNumbers(metadata, "bakelight:target", 3, file);
  const auto field_of_view = metadataNumbers(metadata, "bakelight:fov_deg", 1, file);
  return cameraFrom(Vec3(eye[0], eye[1], eye[2]), Vec3(target[0], target[1], target[2]), field_of_view[0]);
}

Reference readReference(const PlanFile& file, const formats::FrameSettings& frame, const Sources& sources) {
  return referenceFrom(sources.image(file.path), frame.width_px, frame.height_px, file.path.string());
}

// What the player shows, on black.
formats::Image displayed(const Picture& picture, double exposure) {
  formats::Image display = picture.linear;
  for (std::size_t i = 0; i < display.values.size(); ++i)
    if (i % 4 != 3)
      display.values[i] =
          static_cast<float>(transport::displayCode(display.values[i] * static_cast<float>(exposure))) / 255;
  return display;
}

std::vector<std::size_t> frontOf(const std::vector<VariantFigures>& variants,
                                 const std::function<double(const VariantFigures&)>& cost) {
  std::vector<CostAndError> points;
  for (const VariantFigures& variant : variants) points.push_back({cost(variant), variant.errors.rel_rmse});
  return paretoFront(points);
}

}  // namespace

std::optional<double> VariantFigures::leftOutError() const {
  for (const CauseError& cause : causes)
    if (cause.cause == "left_out") return cause.rel_rmse;
  return std::nullopt;
}

double relativeRmse(const Evaluator::Pictures& a, const Evaluator::Pictures& b,
                    const Evaluator::Pictures& truth) {
  std::vector<double> errors;
  for (std::size_t view = 0; view < truth.size(); ++view)
    errors.push_back(viewErrors(a[view], b[view], truth[view].picture).relativeRmse());
  return rootMeanSquare(errors);
}

Evaluator::Evaluator(const Plan& plan, const Sources& sources)
    : plan_(plan), sources_(sources), pictures_(kKeptPictures) {
  std::vector<transport::OrbitCamera> cameras;
  for (const PlanView& view : plan.views) {
    truth_.push_back(readReference(view.reference, view.frame, sources));
    cameras.push_back(cameraOf(view, sources));
  }
  renderer_ = std::make_unique<Renderer>(plan, std::move(cameras), sources);
  // Exposure depends on the lights alone, but an emitter's size may be in units of the object.
  const formats::Pack pack = sources.pack(plan.variants.front().pack.path);
  const transport::LightNeeds needs = transport::makePackShading(pack)->needs();
  for (std::size_t view = 0; view < plan.views.size(); ++view) {
    exposures_.push_back(renderer_->exposure(pack.mesh, needs, view));
    flips_.emplace_back(displayed(truth_[view].picture, exposures_[view]));
  }
}

Evaluation Evaluator::evaluate(int rounds, const std::function<void()>& advanced, bool storage) {
  Evaluation evaluation;
  for (const Reference& reference : truth_) evaluation.noise.push_back(relativeNoise(reference));
  for (const PlanVariant& variant : plan_.variants) {
    VariantFigures figures;
    measureErrors(variant, figures);
    measureCauses(variant, figures);
    figures.bytes = sources_.bytes(variant.pack.path);
    for (const StageFigures& stage : variant.stages) {
      figures.bake_s += stage.wall_s;
      figures.bake_cpu_s += stage.cpu_s;
    }
    evaluation.variants.push_back(std::move(figures));
    advanced();
  }
  measureTimes(rounds, evaluation, advanced);
  if (storage) measureStorage(evaluation, advanced);
  const auto& variants = evaluation.variants;
  evaluation.fronts.frame_ms = frontOf(variants, [](const VariantFigures& v) { return v.frame_ms(); });
  evaluation.fronts.bytes =
      frontOf(variants, [](const VariantFigures& v) { return static_cast<double>(v.bytes); });
  evaluation.fronts.bake_s = frontOf(variants, [](const VariantFigures& v) { return v.bake_s; });
  return evaluation;
}

std::shared_ptr<const Evaluator::Pictures> Evaluator::picturesOf(const PlanFile& pack) {
  return pictures_.get(pack.hash, [&] {
    const formats::Pack read = sources_.pack(pack.path);
    std::vector<Picture> made;
    if (plan_.views.front().windows_measured)
      if (auto windowed = measureWindows(read, plan_, *renderer_, truth_, exposures_)) {
        made = std::move(windowed->pictures);
        windows_[pack.hash] = std::move(windowed->windows);
      }
    if (made.empty()) made = renderer_->picturesOf(read);
    Pictures pictures;
    for (Picture& picture : made) pictures.push_back({std::move(picture), {}});
    return pictures;
  });
}

std::optional<WindowChoice> Evaluator::windowOf(const PlanFile& pack, std::size_t view) {
  picturesOf(pack);
  const auto found = windows_.find(pack.hash);
  return found == windows_.end() ? std::nullopt : std::optional(found->second[view]);
}

std::shared_ptr<const Evaluator::Pictures> Evaluator::picturesOf(const ChainLink& link) {
  if (link.references.empty()) return picturesOf(link.pack);
  std::string key;
  for (const PlanFile& file : link.references) key += file.hash + ' ';
  return pictures_.get(key, [&] {
    Pictures pictures;
    for (std::size_t view = 0; view < plan_.views.size(); ++view)
      pictures.push_back(readReference(link.references[view], plan_.views[view].frame, sources_));
    return pictures;
  });
}

void Evaluator::measureErrors(const PlanVariant& variant, VariantFigures& figures) {
  const auto pictures = picturesOf(variant.pack);
  std::vector<double> rel_rmse;
  std::vector<float> differences;
  double flip_sum = 0, coverage_sum = 0;
  std::size_t flip_pixels = 0;
  for (std::size_t view = 0; view < plan_.views.size(); ++view) {
    const ViewErrors errors = viewErrors(truth_[view], (*pictures)[view], truth_[view].picture);
    if (errors.pixels == 0)
      throw badInput({variant.pack.path.string(), "", ""},
                     "in the view \"" + plan_.views[view].name + "\" no pixel sees both this pack and what " +
                         plan_.views[view].reference.path.string() + " shows",
                     "a reference of the same object and camera");
    std::size_t pixels = 0;
    const double flip_of_view = flip((*pictures)[view].picture, view, pixels);
    figures.view_errors.push_back({errors.relativeRmse(), percentile(errors.relative_differences, 0.99),
                                   flip_of_view, errors.coverage_error});
    rel_rmse.push_back(errors.relativeRmse());
    differences.insert(differences.end(), errors.relative_differences.begin(),
                       errors.relative_differences.end());
    flip_sum += flip_of_view * static_cast<double>(pixels);
    flip_pixels += pixels;
    coverage_sum += errors.coverage_error;
  }
  for (std::size_t view = 0; view < plan_.views.size(); ++view) {
    const bool is_first = view == 0 || plan_.views[view].light != plan_.views[view - 1].light;
    if (const auto window = windowOf(variant.pack, view); window && is_first)
      figures.windows.push_back({plan_.views[view].light, *window});
  }
  figures.errors = {rootMeanSquare(rel_rmse), percentile(std::move(differences), 0.99),
                    flip_pixels > 0 ? flip_sum / static_cast<double>(flip_pixels) : 0,
                    coverage_sum / static_cast<double>(plan_.views.size())};
}

void Evaluator::measureCauses(const PlanVariant& variant, VariantFigures& figures) {
  std::shared_ptr<const Pictures> before;
  for (const ChainLink& link : variant.chain) {
    const std::shared_ptr<const Pictures> after = picturesOf(link);
    figures.causes.push_back({link.cause, relativeRmse(before ? *before : truth_, *after, truth_)});
    before = after;
  }
}

// Mean over the pixels where either picture shows something, so that empty background does not count.
double Evaluator::flip(const Picture& picture, std::size_t view, std::size_t& pixels) const {
  const std::vector<float> errors = flips_[view].errorsOf(displayed(picture, exposures_[view]));
  double sum = 0;
  pixels = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (picture.linear.values[4 * i + 3] <= 0 && truth_[view].picture.linear.values[4 * i + 3] <= 0) continue;
    sum += errors[i];
    ++pixels;
  }
  return pixels > 0 ? sum / static_cast<double>(pixels) : 0;
}

void Evaluator::measureStorage(Evaluation& evaluation, const std::function<void()>& advanced) {
  for (const PlanVariant& variant : plan_.variants) {
    const formats::Pack pack = sources_.pack(variant.pack.path);
    if (!hasStorage(pack)) continue;
    evaluation.storage = report::measureStorage(pack, plan_, *renderer_, truth_, advanced);
    return;
  }
}

// Every round turns the light and moves the eye, as a player's user does.
void Evaluator::measureTimes(int rounds, Evaluation& evaluation, const std::function<void()>& advanced) {
  std::vector<VariantFigures>& variants = evaluation.variants;
  struct Candidate {
    std::unique_ptr<transport::PackShading> shading;
    Renderer::Conditions conditions;
  };
  std::vector<std::unique_ptr<Candidate>> candidates;
  std::vector<Measurement> measurements;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    const formats::Pack pack = sources_.pack(plan_.variants[v].pack.path);
    variants[v].vertices = pack.mesh.vertexCount();
    auto shading = transport::makePackShading(pack);
    const transport::LightNeeds needs = shading->needs();
    candidates.push_back(std::make_unique<Candidate>(
        Candidate{std::move(shading), renderer_->conditions(pack.mesh, needs, 0)}));
    measurements.push_back([candidate = candidates.back().get()](int round) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(round * std::numbers::pi / 180, Vec3::UnitY()).toRotationMatrix();
      Renderer::Conditions& conditions = candidate->conditions;
      // Lights are drawn into a cube map before the clock starts: they are the same for all who take one.
      if (conditions.cube_of) conditions.cube = conditions.turnedCube(turn);
      const double light_change_ms = millisecondsOf([&] { conditions.light(*candidate->shading, turn); });
      const double view_change_ms =
          millisecondsOf([&] { candidate->shading->setView(Vec3(turn * conditions.eye)); });
      return std::vector<double>{light_change_ms, view_change_ms};
    });
    advanced();
  }
  const auto times = measureInTurn(measurements, rounds);
  for (std::size_t v = 0; v < variants.size(); ++v) {
    variants[v].light_change_ms = times[v][0];
    variants[v].view_change_ms = times[v][1];
  }
}

}  // namespace bakelight::report
