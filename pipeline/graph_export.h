// A graph for people and for other programs.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "formats/json.h"
#include "pipeline/graph.h"

namespace bakelight::pipeline {

std::string toDot(
    const Graph& graph);  // Graphviz: files are notes, stages are boxes, left-out ones are dashed
std::string toText(const Graph& graph);  // one stage a line: "bunny transfer <- simplify.mesh"
formats::Json toJson(const Graph& graph);

}  // namespace bakelight::pipeline
