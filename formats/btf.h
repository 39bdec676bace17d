// Bidirectional texture functions (BTF; Dana et al. 1999): pictures of a flat piece of a material, one for each pair
// of a direction of view and a direction of light. They are many (151 × 151 of 400 × 400 texels are 43 GB as floats),
// so a file is opened and decoded part by part.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace bakelight::formats {

// Away from the surface: polar angle from its normal, azimuth from the pictures' right (x) towards their top (y).
struct BtfDirection {
  double polar_rad = 0, azimuth_rad = 0;
  bool operator==(const BtfDirection&) const = default;
};

struct BtfInfo {
  std::string file;    // as it was opened, for messages
  std::string layout;  // "DFMF", "FMF", "PVF", "BDI", "pictures", "table"
  std::vector<BtfDirection> views, lights;
  int width = 0, height = 0;  // texels, rows from the top
  // Whether values are radiance under a directional light of unit irradiance normal to itself, so that the cosine of the
  // light's polar angle is multiplied in, or reflectance per steradian, without.
  bool cosine_inside = true;
  double texels_per_mm = 0;  // 0: not known
  std::string measurement_setup, image_sensor, light_source;
  std::array<float, 3> rgb_scale = {1, 1, 1};  // as the file has it; values are not multiplied by it
  std::uint64_t bytes = 0;                     // of the file or files
  std::vector<std::string> notes;              // what a user should know of it
};

// Texels y · width + x, in that order.
struct BtfTexels {
  std::size_t first = 0, count = 0;
};

// All pictures towards one view, ready to be decoded; from several threads at once. Stays valid after its Btf.
class BtfView {
 public:
  virtual ~BtfView() = default;
  // rgb[(c · lights + i) · count + t]: red, green, blue, linear; `lights` are indices into BtfInfo::lights, of which
  // each is one of Btf::lightsOf this view. rgb has 3 · lights · count elements. Throws Error(kBadInput) naming
  // view, light and texel if a value is not finite.
  void decode(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const;

 protected:
  BtfView(std::shared_ptr<const BtfInfo> info, int view) : info_(std::move(info)), view_(view) {}
  const BtfInfo& info() const { return *info_; }
  int index() const { return view_; }

 private:
  virtual void decodeValues(std::span<const int> lights, BtfTexels texels, std::span<float> rgb) const = 0;

  std::shared_ptr<const BtfInfo> info_;
  int view_;
};

class Btf {
 public:
  virtual ~Btf() = default;
  const BtfInfo& info() const { return *info_; }
  std::size_t texelCount() const { return static_cast<std::size_t>(info().width) * info().height; }
  // Under which lights there is a picture towards the view, ascending: all, but of sets with gaps.
  virtual std::vector<int> lightsOf(int view) const;
  // Cheap for the binary layouts; of pictures it reads them.
  virtual std::shared_ptr<const BtfView> view(int view) const = 0;

 protected:
  explicit Btf(BtfInfo info) : info_(std::make_shared<const BtfInfo>(std::move(info))) {}
  const std::shared_ptr<const BtfInfo>& sharedInfo() const { return info_; }

 private:
  std::shared_ptr<const BtfInfo> info_;
};

// In memory: values[(((view · lights + light) · height + y) · width + x) · 3 + c].
std::unique_ptr<Btf> btfOf(BtfInfo info, std::vector<float> values);

// Whether the file begins as the University of Bonn's `.btf` files do.
bool isBtfFile(const std::filesystem::path& path);

// Opens a binary `.btf` of the University of Bonn (docs/BTF.md): the file is mapped, and nothing of it is expanded
// but what is decoded. Throws Error(kBadInput) naming file, offset and reason for what is none, is truncated, too
// long or contradicts itself, or holds a variant that cannot be read.
std::unique_ptr<Btf> openBtf(const std::filesystem::path& path);

}  // namespace bakelight::formats
