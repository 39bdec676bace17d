#include "tools/atlas/charts/cuts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <queue>
#include <utility>

#include "formats/error.h"
#include "formats/json_reader.h"

namespace bakelight::atlas {
namespace {

using formats::childPointer;
using formats::Json;
using formats::JsonReader;
using PlacePair = std::array<std::uint32_t, 2>;

constexpr double kFarthest = 0.01;  // of the bounding box's diagonal
constexpr const char* kPoint = "a vertex number, or a position [x, y, z]";

ErrorPlace placeAt(const std::string& file, const std::string& pointer) {
  return {file, "", pointer};
}

std::string pointerOf(const std::string& list, std::size_t index) {
  return childPointer(list, std::to_string(index));
}

CutPoint pointFrom(const JsonReader& point) {
  const Json& json = point.value();
  if (json.is_number_integer()) {
    if (json < 0 || json > std::numeric_limits<std::uint32_t>::max())
      throw point.error(json.dump() + " is no vertex", kPoint);
    return json.get<std::uint32_t>();
  }
  const bool is_position = json.is_array() && json.size() == 3 &&
                           std::all_of(json.begin(), json.end(), [](const Json& x) { return x.is_number(); });
  if (!is_position) throw point.error(json.dump() + " is no point", kPoint);
  const std::vector<double> position = point.numbers(3);
  return Vec3(position[0], position[1], position[2]);
}

std::vector<CutPoint> pointsFrom(const std::vector<JsonReader>& list) {
  std::vector<CutPoint> points;
  for (const JsonReader& point : list) points.push_back(pointFrom(point));
  return points;
}

// The places of the surface and the edges between them.
class EdgeGraph {
 public:
  explicit EdgeGraph(const Surface& surface) : surface_(surface), neighbors_(surface.positions.size()) {
    for (const Triangle& t : surface.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        neighbors_[t[k]].push_back(t[(k + 1) % 3]);
        neighbors_[t[(k + 1) % 3]].push_back(t[k]);
        box_.extend(surface.positions[t[k]]);
      }
    for (std::vector<std::uint32_t>& list : neighbors_) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
  }

  bool isUsed(std::uint32_t place) const { return !neighbors_[place].empty(); }
  double diagonal() const { return box_.diagonal().norm(); }

  std::uint32_t nearest(const Vec3& position) const {
    std::uint32_t best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t p = 0; p < neighbors_.size(); ++p) {
      const double distance = (surface_.positions[p] - position).squaredNorm();
      if (isUsed(p) && distance < least) best = p, least = distance;
    }
    return best;
  }

  // Places from `from` to `to` along the shortest path (Dijkstra 1959); empty if there is none.
  std::vector<std::uint32_t> path(std::uint32_t from, std::uint32_t to) const {
    if (std::binary_search(neighbors_[from].begin(), neighbors_[from].end(), to)) return {from, to};
    std::vector<double> distance(neighbors_.size(), std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> before(neighbors_.size(), from);
    using Entry = std::pair<double, std::uint32_t>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    distance[from] = 0;
    queue.emplace(0.0, from);
    while (!queue.empty() && queue.top().second != to) {
      const auto [so_far, place] = queue.top();
      queue.pop();
      if (so_far > distance[place]) continue;
      for (const std::uint32_t next : neighbors_[place]) {
        const double length = so_far + (surface_.positions[next] - surface_.positions[place]).norm();
        if (length >= distance[next]) continue;
        distance[next] = length;
        before[next] = place;
        queue.emplace(length, next);
      }
    }
    if (queue.empty()) return {};
    std::vector<std::uint32_t> places = {to};
    while (places.back() != from) places.push_back(before[places.back()]);
    std::reverse(places.begin(), places.end());
    return places;
  }

 private:
  const Surface& surface_;
  std::vector<std::vector<std::uint32_t>> neighbors_;
  Eigen::AlignedBox3d box_;
};

std::uint32_t placeOf(const CutPoint& point, const Surface& surface, const EdgeGraph& graph,
                      const ErrorPlace& error_place) {
  if (const auto* vertex = std::get_if<std::uint32_t>(&point)) {
    if (*vertex >= surface.place_of_vertex.size())
      throw badInput(error_place, "vertex " + std::to_string(*vertex) + " does not exist",
                     "a vertex number below " + std::to_string(surface.place_of_vertex.size()));
    const std::uint32_t place = surface.place_of_vertex[*vertex];
    if (!graph.isUsed(place))
      throw badInput(error_place,
                     "vertex " + std::to_string(*vertex) + " belongs to no triangle that has an area");
    return place;
  }
  const Vec3 position = (std::get<Vec3>(point) - surface.center) * surface.scale;
  const std::uint32_t place = graph.nearest(position);
  const double share = (surface.positions[place] - position).norm() / graph.diagonal();
  if (!(share <= kFarthest))
    throw badInput(
        error_place,
        "the nearest vertex is " + std::to_string(100 * share) + "% of the bounding box's diagonal away",
        "a position within 1% of a vertex",
        "give it in the mesh file's own coordinates, or give the vertex's number");
  return place;
}

}  // namespace

Cuts cutsFromJson(const Json& json, const std::string& file) {
  const JsonReader object(json, file);
  object.allowKeys({"cuts", "corners"});
  Cuts cuts;
  cuts.corners = pointsFrom(object.items("corners"));
  for (const JsonReader& line : object.items("cuts")) {
    cuts.lines.push_back(pointsFrom(line.items()));
    if (cuts.lines.back().size() < 2)
      throw line.error("has " + std::to_string(cuts.lines.back().size()) + " points",
                       "a line of two points or more");
  }
  return cuts;
}

Cuts readCuts(const std::filesystem::path& path) {
  return cutsFromJson(formats::readJson(path), path.string());
}

AppliedCuts applyCuts(Surface& surface, const Cuts& cuts, const std::string& file) {
  const EdgeGraph graph(surface);
  AppliedCuts applied;
  for (std::size_t i = 0; i < cuts.corners.size(); ++i)
    applied.corner_places.push_back(
        placeOf(cuts.corners[i], surface, graph, placeAt(file, pointerOf("/corners", i))));
  std::sort(applied.corner_places.begin(), applied.corner_places.end());
  applied.corner_places.erase(std::unique(applied.corner_places.begin(), applied.corner_places.end()),
                              applied.corner_places.end());

  std::vector<PlacePair> edges;
  for (std::size_t line = 0; line < cuts.lines.size(); ++line) {
    const std::string pointer = pointerOf("/cuts", line);
    std::vector<std::uint32_t> places;
    for (std::size_t i = 0; i < cuts.lines[line].size(); ++i)
      places.push_back(placeOf(cuts.lines[line][i], surface, graph, placeAt(file, pointerOf(pointer, i))));
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const std::vector<std::uint32_t> path = graph.path(places[i], places[i + 1]);
      if (path.empty() && places[i] != places[i + 1])
        throw badInput(placeAt(file, pointerOf(pointer, i + 1)),
                       "no path along edges leads here from the point before",
                       "points on one connected part of the mesh", "begin another line");
      for (std::size_t k = 0; k + 1 < path.size(); ++k) edges.push_back({path[k], path[k + 1]});
    }
  }
  applied.edges = cutEdges(surface, edges);
  return applied;
}

MarkedEdges cutMarkedEdges(Surface& surface, std::span<const std::array<std::uint32_t, 2>> edges) {
  std::vector<PlacePair> places;
  for (const auto& [a, b] : edges) {
    const auto [low, high] = std::minmax(surface.place_of_vertex[a], surface.place_of_vertex[b]);
    places.push_back({low, high});
  }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  MarkedEdges marked;
  marked.cut = cutEdges(surface, places);
  marked.unknown = static_cast<std::int64_t>(places.size()) - marked.cut;
  return marked;
}

}  // namespace bakelight::atlas
