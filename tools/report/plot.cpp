#include "tools/report/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "tools/report/axis.h"
#include "tools/report/text.h"

namespace bakelight::report {
namespace {

constexpr double kWidth = 360, kHeight = 290;
constexpr double kLeft = 46, kRight = 350, kTop = 10, kBottom = 246;
// Of the cost axis's figures: below those of the error axis, which they meet in the corner.
constexpr double kTickDrop = 16;
constexpr double kMarkerRadius = 4.5, kMarkerExtent = 6.5;  // of a circle; of any, with its outline
// Of the labels' font, bold 10: the widest in use is DejaVu Sans.
constexpr double kLetter = 7, kAscent = 9.5, kDescent = 2.5;

struct Position {
  double x, y;
};

struct Box {
  double left, top, right, bottom;

  bool overlaps(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  bool within(const Box& other) const {
    return left >= other.left && right <= other.right && top >= other.top && bottom <= other.bottom;
  }
};

std::size_t letters(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string line(Position from, Position to, const char* style) {
  return "<line class=\"" + std::string(style) + "\" x1=\"" + coordinate(from.x) + "\" y1=\"" +
         coordinate(from.y) + "\" x2=\"" + coordinate(to.x) + "\" y2=\"" + coordinate(to.y) + "\"/>";
}

std::string text(Position at, const char* anchor, const char* style, const std::string& content) {
  return "<text class=\"" + std::string(style) + "\" text-anchor=\"" + anchor + "\" x=\"" + coordinate(at.x) +
         "\" y=\"" + coordinate(at.y) + "\">" + escaped(content) + "</text>";
}

// Where a label may stand beside its point, best first: nothing lies below and to the left of a front.
struct Placement {
  double dx, dy;
  const char* anchor;
};
const std::vector<Placement>& placements() {
  static const std::vector<Placement> kPlacements = [] {
    std::vector<Placement> result;
    for (const double away : {0.0, 9.0, 20.0, 32.0, 44.0, 57.0, 70.0}) {
      result.push_back({-7 - away * 0.6, 13 + away, "end"});
      result.push_back({7 + away * 0.6, 13 + away, "start"});
      result.push_back({0, 17 + away, "middle"});
      result.push_back({7 + away * 0.6, -7 - away, "start"});
      result.push_back({-7 - away * 0.6, -7 - away, "end"});
    }
    return result;
  }();
  return kPlacements;
}

class PlotWriter {
 public:
  explicit PlotWriter(const Plot& plot)
      : plot_(plot), costs_(valuesOf(&PlotPoint::cost), 6), errors_(valuesOf(&PlotPoint::error), 7) {
    for (const PlotPoint& point : plot.points) positions_.push_back(positionOf(point.cost, point.error));
  }

  std::string svg() const {
    std::string svg = "<svg class=\"plot\" viewBox=\"0 0 " + coordinate(kWidth) + ' ' + coordinate(kHeight) +
                      "\" role=\"img\" aria-label=\"" + escaped(plot_.title) + "\">";
    return svg + axes() + frontLine() + points() + labels() + "</svg>\n";
  }

 private:
  // Whiskers may leave the plot: a disturbed measurement should not squeeze the points.
  std::vector<double> valuesOf(double PlotPoint::*member) const {
    std::vector<double> values;
    for (const PlotPoint& point : plot_.points) values.push_back(point.*member);
    return values;
  }

  Position positionOf(double cost, double error) const {
    return {std::lerp(kLeft, kRight, costs_.position(cost)),
            std::lerp(kBottom, kTop, errors_.position(error))};
  }

  std::string axes() const {
    std::string svg = "<rect class=\"area\" x=\"" + coordinate(kLeft) + "\" y=\"" + coordinate(kTop) +
                      "\" width=\"" + coordinate(kRight - kLeft) + "\" height=\"" +
                      coordinate(kBottom - kTop) + "\"/>";
    for (const double tick : costs_.ticks()) {
      const double x = std::lerp(kLeft, kRight, costs_.position(tick));
      svg += line({x, kTop}, {x, kBottom}, "grid") +
             text({x, kBottom + kTickDrop}, "middle", "tick", plot_.cost_text(tick));
    }
    for (const double tick : errors_.ticks()) {
      const double y = std::lerp(kBottom, kTop, errors_.position(tick));
      svg += line({kLeft, y}, {kRight, y}, "grid") +
             text({kLeft - 5, y + 3.5}, "end", "tick", plot_.error_text(tick));
    }
    svg += text({(kLeft + kRight) / 2, kBottom + 33}, "middle", "axis", plot_.cost_label);
    const double middle = (kTop + kBottom) / 2;
    svg += "<text class=\"axis\" text-anchor=\"middle\" transform=\"translate(11 " + coordinate(middle) +
           ") rotate(-90)\">" + escaped(plot_.error_label) + "</text>";
    return svg;
  }

  // What one can have: at a cost between two points of the front, the error of the cheaper one.
  std::string frontLine() const {
    if (plot_.front.empty()) return "";
    std::string path = "M" + coordinate(positions_[plot_.front.front()].x) + ' ' + coordinate(kTop);
    for (std::size_t i = 0; i < plot_.front.size(); ++i) {
      const Position at = positions_[plot_.front[i]];
      if (i > 0) path += "H" + coordinate(at.x);
      path += "V" + coordinate(at.y);
    }
    return "<path class=\"front\" d=\"" + path + "H" + coordinate(kRight) + "\"/>";
  }

  bool onFront(std::size_t point) const {
    return std::find(plot_.front.begin(), plot_.front.end(), point) != plot_.front.end();
  }

  std::string points() const {
    std::string beaten, front;  // those of the front on top
    for (std::size_t i = 0; i < plot_.points.size(); ++i) {
      const PlotPoint& point = plot_.points[i];
      const bool on_front = onFront(i);
      std::string svg = "<g class=\"point g" + std::to_string(point.marker) + (on_front ? " on-front" : "") +
                        "\" data-variant=\"" + escaped(point.name) + "\"><title>" + escaped(point.title) +
                        "</title>";
      if (point.cost_high > point.cost_low)
        svg += line(positionOf(point.cost_low, point.error), positionOf(point.cost_high, point.error),
                    "whisker");
      (on_front ? front : beaten) +=
          svg + markerSvg(point.marker, positions_[i].x, positions_[i].y, on_front) + "</g>";
    }
    return beaten + front;
  }

  static Box boxOf(const Placement& placement, Position at, double width) {
    const double x = at.x + placement.dx;
    const double left = placement.anchor == std::string_view("end")      ? x - width
                        : placement.anchor == std::string_view("middle") ? x - width / 2
                                                                         : x;
    return {left, at.y + placement.dy - kAscent, left + width, at.y + placement.dy + kDescent};
  }

  std::string labels() const {
    std::vector<Box> taken;
    for (const Position& at : positions_)
      taken.push_back(
          {at.x - kMarkerExtent, at.y - kMarkerExtent, at.x + kMarkerExtent, at.y + kMarkerExtent});
    std::string svg;
    for (const std::size_t i : plot_.front) {
      const std::string& label = plot_.points[i].label;
      const double width = kLetter * static_cast<double>(letters(label));
      for (const Placement& placement : placements()) {
        const Box box = boxOf(placement, positions_[i], width);
        const bool free =
            box.within({kLeft + 1, kTop + 1, kRight - 1, kBottom - 1}) &&
            std::none_of(taken.begin(), taken.end(), [&](const Box& b) { return b.overlaps(box); });
        if (!free) continue;
        taken.push_back(box);
        const Position at{positions_[i].x + placement.dx, positions_[i].y + placement.dy};
        if (std::abs(placement.dy) > 18)
          svg += line(positions_[i], {at.x, at.y + (placement.dy > 0 ? -8 : 2)}, "leader");
        svg += text(at, placement.anchor, "label", label);
        break;
      }
    }
    return svg;
  }

  const Plot& plot_;
  Axis costs_, errors_;
  std::vector<Position> positions_;
};

std::string polygon(const std::vector<Position>& corners, Position center) {
  std::string points;
  for (const Position& corner : corners)
    points +=
        (points.empty() ? "" : " ") + coordinate(center.x + corner.x) + ',' + coordinate(center.y + corner.y);
  return "<polygon points=\"" + points + "\"";
}

std::string strokes(const std::vector<std::pair<Position, Position>>& lines, Position center) {
  std::string path;
  for (const auto& [from, to] : lines)
    path += "M" + coordinate(center.x + from.x) + ' ' + coordinate(center.y + from.y) + "L" +
            coordinate(center.x + to.x) + ' ' + coordinate(center.y + to.y);
  return "<path d=\"" + path + "\"";
}

}  // namespace

std::string markerSvg(std::size_t marker, double x, double y, bool filled) {
  constexpr double r = kMarkerRadius;
  const std::string style = filled ? " class=\"filled\"/>" : " class=\"hollow\"/>";
  const Position at{x, y};
  switch (marker % kMarkers) {
    case 0:
      return "<circle cx=\"" + coordinate(x) + "\" cy=\"" + coordinate(y) + "\" r=\"" + coordinate(r) + "\"" +
             style;
    case 1:
      return polygon({{-r, -r}, {r, -r}, {r, r}, {-r, r}}, at) + style;
    case 2:
      return polygon({{0, -r - 1}, {r + 0.7, r - 0.5}, {-r - 0.7, r - 0.5}}, at) + style;
    case 3:
      return polygon({{0, -r - 1.2}, {r + 1.2, 0}, {0, r + 1.2}, {-r - 1.2, 0}}, at) + style;
    case 4:
      return polygon({{0, r + 1}, {r + 0.7, -r + 0.5}, {-r - 0.7, -r + 0.5}}, at) + style;
    case 5:
      return strokes({{{-r, -r}, {r, r}}, {{-r, r}, {r, -r}}}, at) + style;
    default:
      return strokes({{{-r - 1, 0}, {r + 1, 0}}, {{0, -r - 1}, {0, r + 1}}}, at) + style;
  }
}

std::string plotSvg(const Plot& plot) {
  return PlotWriter(plot).svg();
}

}  // namespace bakelight::report
