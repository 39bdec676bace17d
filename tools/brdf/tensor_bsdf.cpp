#include "tools/brdf/tensor_bsdf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include "formats/btf_color.h"
#include "formats/error.h"
#include "tools/brdf/tensor_file.h"
#include "transport/directions.h"

namespace bakelight::brdf {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kFloat32 = 10, kByte = 1;

using Fields = std::map<std::string, TensorField>;

const TensorField& field(const Fields& fields, const std::string& name, int type, std::size_t dimensions,
                         const std::string& file) {
  const auto found = fields.find(name);
  if (found == fields.end())
    throw badInput({file, "field " + name, ""}, "there is none", "a measured BRDF of the RGL database");
  if (found->second.type != type || found->second.shape.size() != dimensions)
    throw badInput({file, "field " + name, ""},
                   "it has " + std::to_string(found->second.shape.size()) + " dimensions of type " +
                       std::to_string(found->second.type),
                   std::to_string(dimensions) + " of type " + std::to_string(type));
  return found->second;
}

std::vector<float> floats(const Fields& fields, const std::string& name, std::size_t dimensions,
                          const std::string& file) {
  const TensorField& tensor = field(fields, name, kFloat32, dimensions, file);
  std::vector<float> values(tensor.count);
  if (!values.empty()) std::memcpy(values.data(), tensor.bytes.data(), tensor.bytes.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      throw badInput({file, "field " + name + ", element " + std::to_string(i), ""}, "it is not finite",
                     "a number");
  return values;
}

std::vector<float> ascending(const Fields& fields, const std::string& name, const std::string& file) {
  std::vector<float> values = floats(fields, name, 1, file);
  if (values.empty() || std::ranges::adjacent_find(values, std::greater_equal<>()) != values.end())
    throw badInput({file, "field " + name, ""}, "its values do not ascend", "one or more that do");
  return values;
}

// A grid over the unit square, rows along y, read bilinearly.
struct Grid {
  std::size_t width = 0, height = 0;
  std::vector<float> values;  // one grid after the other

  struct Cell {
    std::size_t column, row;
    double across, down;
  };
  Cell cell(double x, double y) const {
    const double at_x = std::clamp(x, 0.0, 1.0) * static_cast<double>(width - 1);
    const double at_y = std::clamp(y, 0.0, 1.0) * static_cast<double>(height - 1);
    const std::size_t column = std::min(static_cast<std::size_t>(at_x), width - 2);
    const std::size_t row = std::min(static_cast<std::size_t>(at_y), height - 2);
    return {column, row, at_x - static_cast<double>(column), at_y - static_cast<double>(row)};
  }
  double at(std::size_t grid, const Cell& cell) const {
    const float* corner = &values[(grid * height + cell.row) * width + cell.column];
    return (1 - cell.down) * ((1 - cell.across) * corner[0] + cell.across * corner[1]) +
           cell.down * ((1 - cell.across) * corner[width] + cell.across * corner[width + 1]);
  }
};

Grid gridOf(const Fields& fields, const std::string& name, std::size_t dimensions, const std::string& file) {
  const std::vector<std::uint64_t>& shape = field(fields, name, kFloat32, dimensions, file).shape;
  const std::uint64_t height = shape[dimensions - 2], width = shape[dimensions - 1];
  if (width < 2 || height < 2)
    throw badInput({file, "field " + name, ""},
                   "its grids are " + std::to_string(width) + " × " + std::to_string(height),
                   "2 × 2 or larger");
  return {width, height, floats(fields, name, dimensions, file)};
}

// The share of the grids around an angle's place among those that were measured.
struct Shares {
  std::array<std::size_t, 4> grid;
  std::array<double, 4> weight;
};

std::pair<std::size_t, double> placeAmong(const std::vector<float>& values, double value) {
  if (values.size() == 1) return {0, 0};
  const auto above = std::upper_bound(values.begin() + 1, values.end() - 1, static_cast<float>(value));
  const auto low = static_cast<std::size_t>(above - values.begin()) - 1;
  const double width = static_cast<double>(values[low + 1]) - values[low];
  return {low, std::clamp((value - values[low]) / width, 0.0, 1.0)};
}

// The map of the unit square to itself that makes a density even, of several densities and what lies between them.
class Warp {
 public:
  Warp() = default;
  Warp(Grid density, const std::string& file) : density_(std::move(density)) {
    const std::size_t cells = density_.width * density_.height, grids = density_.values.size() / cells;
    along_x_.resize(density_.values.size());
    along_y_.resize(grids * density_.height);
    for (std::size_t g = 0; g < grids; ++g) {
      double total = 0;
      for (std::size_t y = 0; y < density_.height; ++y) {
        const float* row = &density_.values[g * cells + y * density_.width];
        double sum = 0;
        for (std::size_t x = 0; x < density_.width; ++x) {
          if (x > 0) sum += (static_cast<double>(row[x - 1]) + row[x]) / 2;
          along_x_[g * cells + y * density_.width + x] = sum;
          if (row[x] < 0) total = NAN;
        }
        if (y > 0) total += (rowSum(g, y - 1) + rowSum(g, y)) / 2;
        along_y_[g * density_.height + y] = total;
      }
      if (!(total > 0))
        throw badInput({file, "field vndf, grid " + std::to_string(g), ""}, "it is no density",
                       "values from 0, not all 0");
      for (std::size_t i = 0; i < cells; ++i) {
        density_.values[g * cells + i] = static_cast<float>(density_.values[g * cells + i] / total);
        along_x_[g * cells + i] /= total;
      }
      for (std::size_t y = 0; y < density_.height; ++y) along_y_[g * density_.height + y] /= total;
    }
  }

  // Where of the even square a point of the density's lies.
  std::array<double, 2> evened(double x, double y, const Shares& shares) const {
    const Grid::Cell cell = density_.cell(x, y);
    double within = 0, first = 0, second = 0, below = 0;
    for (std::size_t s = 0; s < 4; ++s) {
      const std::size_t g = shares.grid[s];
      const auto partial = [&](std::size_t row) {
        const std::size_t at = (g * density_.height + row) * density_.width + cell.column;
        const double a = density_.values[at], b = density_.values[at + 1];
        return along_x_[at] + cell.across * (a + cell.across * (b - a) / 2);
      };
      within += shares.weight[s] * ((1 - cell.down) * partial(cell.row) + cell.down * partial(cell.row + 1));
      first += shares.weight[s] * rowSum(g, cell.row);
      second += shares.weight[s] * rowSum(g, cell.row + 1);
      below += shares.weight[s] * along_y_[g * density_.height + cell.row];
    }
    const double row = (1 - cell.down) * first + cell.down * second;
    return {row > 0 ? within / row : 0, below + cell.down * (first + cell.down * (second - first) / 2)};
  }

 private:
  double rowSum(std::size_t grid, std::size_t row) const {
    return along_x_[(grid * density_.height + row + 1) * density_.width - 1];
  }

  Grid density_;
  std::vector<double> along_x_, along_y_;  // sums of each row to a column, and of rows
};

struct Tensors {
  std::vector<float> polar_rad, azimuth_rad;  // of the eye
  Grid normals, areas, values;                // values: azimuths × polar angles × 3
  Warp warp;
  bool is_isotropic = true, has_jacobian = true;

  Shares sharesAt(double polar, double azimuth) const {
    const auto [a, of_a] = placeAmong(azimuth_rad, azimuth);
    const auto [p, of_p] = placeAmong(polar_rad, polar);
    const std::size_t next_a = std::min(a + 1, azimuth_rad.size() - 1),
                      next_p = std::min(p + 1, polar_rad.size() - 1);
    const std::size_t polars = polar_rad.size();
    return {{a * polars + p, a * polars + next_p, next_a * polars + p, next_a * polars + next_p},
            {(1 - of_a) * (1 - of_p), (1 - of_a) * of_p, of_a * (1 - of_p), of_a * of_p}};
  }

  Vec3 value(const Vec3& incident, const Vec3& outgoing) const {
    const Vec3 sum = incident + outgoing;
    if (incident.z() <= 0 || outgoing.z() < 0 || sum.norm() == 0) return Vec3::Zero();
    const Vec3 half = sum.normalized();
    const double polar = std::acos(std::clamp(outgoing.z(), 0.0, 1.0)),
                 azimuth = std::atan2(outgoing.y(), outgoing.x());
    const double half_azimuth = std::atan2(half.y(), half.x()) - (is_isotropic ? azimuth : 0);
    const auto across = [](double angle) { return std::sqrt(angle * 2 / kPi); };
    const auto around = [](double angle) { return (angle + kPi) / (2 * kPi); };
    const double x = across(std::acos(std::clamp(half.z(), 0.0, 1.0)));
    const double y = around(half_azimuth) - std::floor(around(half_azimuth));
    const Shares shares = sharesAt(polar, azimuth);
    const auto [even_x, even_y] = warp.evened(x, y, shares);
    const Grid::Cell cell = values.cell(even_x, even_y);
    Vec3 result = Vec3::Zero();
    for (std::size_t s = 0; s < 4; ++s)
      for (std::size_t c = 0; c < 3; ++c)
        if (shares.weight[s] > 0)
          result[static_cast<Eigen::Index>(c)] += shares.weight[s] * values.at(3 * shares.grid[s] + c, cell);
    result = result.cwiseMax(0) / incident.z();
    if (!has_jacobian) return result;
    const double area = areas.at(0, areas.cell(across(polar), around(azimuth)));
    return area > 0 ? Vec3(result * normals.at(0, normals.cell(x, y)) / (4 * area)) : Vec3::Zero();
  }
};

void requireGrids(const Fields& fields, const std::string& name, const std::vector<std::uint64_t>& leading,
                  const std::string& file) {
  const std::vector<std::uint64_t>& shape = fields.at(name).shape;
  if (!std::equal(leading.begin(), leading.end(), shape.begin()))
    throw badInput({file, "field " + name, ""},
                   "its leading dimensions are others than those of phi_i and theta_i",
                   std::to_string(leading[0]) + " × " + std::to_string(leading[1]) +
                       (leading.size() > 2 ? " × " + std::to_string(leading[2]) : ""));
}

// From wavelengths to red, green and blue.
Grid rgbOf(const Grid& spectra, const std::vector<float>& wavelengths) {
  const std::vector<double> nm(wavelengths.begin(), wavelengths.end());
  const std::vector<std::array<float, 3>> weights = formats::rgbOfWavelengths(nm);
  const std::size_t cells = spectra.width * spectra.height, grids = spectra.values.size() / cells / nm.size();
  Grid rgb{spectra.width, spectra.height, std::vector<float>(3 * grids * cells)};
  for (std::size_t g = 0; g < grids; ++g)
    for (std::size_t k = 0; k < nm.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < cells; ++i)
          rgb.values[(3 * g + c) * cells + i] +=
              weights[k][c] * std::max(spectra.values[(g * nm.size() + k) * cells + i], 0.0F);
  return rgb;
}

constexpr int kTurns = 16;

Vec3 turned(const Vec3& direction, double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Vec3::UnitZ()) * direction;
}
double angleOf(int turn) {
  return 2 * kPi * (turn + 0.5) / kTurns;
}

// From the eye's azimuth on, so that it is the same wherever that is.
Vec3 meanOverTurns(const Tensors& tensors, const Vec3& incident, const Vec3& outgoing) {
  const double azimuth = std::atan2(outgoing.y(), outgoing.x());
  const Vec3 eye = turned(outgoing, -azimuth), light = turned(incident, -azimuth);
  const Vec3 mirrored(light.x(), -light.y(), light.z());
  Vec3 sum = Vec3::Zero();
  for (int turn = 0; turn < kTurns; ++turn)
    for (const Vec3& from : {light, mirrored})
      sum += tensors.value(turned(from, angleOf(turn)), turned(eye, angleOf(turn)));
  return sum / (2 * kTurns);
}

double anisotropyOf(const Tensors& tensors) {
  constexpr int kDirections = 60;
  double differences = 0, squares = 0;
  for (const Vec3& outgoing : transport::sphereDirections(kDirections))
    for (const Vec3& incident : transport::sphereDirections(kDirections + 1)) {
      if (incident.z() <= 0.1 || outgoing.z() <= 0.1) continue;
      const Vec3 mean = meanOverTurns(tensors, incident, outgoing);
      for (int turn = 0; turn < kTurns; ++turn) {
        const Vec3 value = tensors.value(turned(incident, angleOf(turn)), turned(outgoing, angleOf(turn)));
        differences += (value - mean).squaredNorm();
        squares += value.squaredNorm();
      }
    }
  return squares > 0 ? std::sqrt(differences / squares) : 0;
}

}  // namespace

MeasuredBrdf readTensorBsdf(std::span<const std::byte> bytes, const std::string& file) {
  const Fields fields = readTensorFields(bytes, file);
  const auto tensors = std::make_shared<Tensors>();
  MeasuredBrdf measured;
  tensors->polar_rad = ascending(fields, "theta_i", file);
  tensors->azimuth_rad = ascending(fields, "phi_i", file);
  const std::uint64_t polars = tensors->polar_rad.size(), azimuths = tensors->azimuth_rad.size();
  tensors->is_isotropic = azimuths <= 2;
  const double around = static_cast<double>(tensors->azimuth_rad.back()) - tensors->azimuth_rad.front();
  if (!tensors->is_isotropic && std::lround(2 * kPi / std::max(around, 1e-3)) != 1)
    throw badInput({file, "field phi_i", ""},
                   "it is anisotropic and covers " + std::to_string(around) + " of azimuths",
                   "all around, or isotropic", "which symmetry the rest has is not known here");
  tensors->normals = gridOf(fields, "ndf", 2, file);
  tensors->areas = gridOf(fields, "sigma", 2, file);
  Grid density = gridOf(fields, "vndf", 4, file);
  requireGrids(fields, "vndf", {azimuths, polars}, file);
  tensors->warp = Warp(std::move(density), file);
  const TensorField& jacobian = field(fields, "jacobian", kByte, 1, file);
  if (jacobian.count != 1)
    throw badInput({file, "field jacobian", ""}, "it has other than one element", "one");
  tensors->has_jacobian = jacobian.bytes[0] != std::byte{0};
  if (fields.contains("rgb")) {
    tensors->values = gridOf(fields, "rgb", 5, file);
    requireGrids(fields, "rgb", {azimuths, polars, 3}, file);
  } else if (fields.contains("spectra")) {
    const std::vector<float> wavelengths = ascending(fields, "wavelengths", file);
    const Grid spectra = gridOf(fields, "spectra", 5, file);
    requireGrids(fields, "spectra", {azimuths, polars, wavelengths.size()}, file);
    tensors->values = rgbOf(spectra, wavelengths);
    measured.notes.push_back("spectra of " + std::to_string(wavelengths.size()) +
                             " wavelengths are seen as red, green and blue under equal energy");
  } else {
    throw badInput({file, "", ""}, "it has neither a field rgb nor spectra",
                   "a measured BRDF of the RGL database");
  }
  if (tensors->is_isotropic) {
    measured.brdf = [tensors](const Vec3& incident, const Vec3& outgoing) {
      return tensors->value(incident, outgoing);
    };
  } else {
    measured.anisotropy = anisotropyOf(*tensors);
    measured.brdf = [tensors](const Vec3& incident, const Vec3& outgoing) {
      return meanOverTurns(*tensors, incident, outgoing);
    };
  }
  return measured;
}

}  // namespace bakelight::brdf
