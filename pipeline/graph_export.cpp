#include "pipeline/graph_export.h"

#include <nlohmann/json.hpp>

namespace bakelight::pipeline {
using formats::Json;
namespace {

std::string quoted(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

// "simplify.mesh", or the file of the asset.
std::string originOf(const Graph& graph, const Input& input) {
  return input.maker ? graph.tasks[*input.maker].stage + "." + input.port : input.file.string();
}

// "" if nothing may omit the task, else by which figures: "own_uv.shortcomings at most 0".
std::string omittedIf(const Task& task) {
  std::string text;
  for (const TaskRule& rule : task.rules)
    if (rule.rule.omit)
      text += (text.empty() ? "" : " or ") + rule.rule.figure.text() + " at most " +
              Json(rule.rule.at_most).dump();
  return text;
}

std::string assetToDot(const Graph& graph, std::size_t asset) {
  std::string nodes, edges;
  for (TaskIndex index = 0; index < graph.tasks.size(); ++index) {
    const Task& task = graph.tasks[index];
    if (task.asset != asset) continue;
    const std::string name = quoted(graph.nameOf(index)), omitted_if = omittedIf(task);
    const char* style = !task.left_out.empty() ? ", style=dashed"
                        : !omitted_if.empty()  ? ", style=dotted"
                                               : "";
    nodes += "    " + name + " [label=" + quoted(task.stage) + style + "];\n";
    for (const TaskRule& rule : task.rules)
      if (rule.rule.omit)
        edges += "    " + quoted(graph.nameOf(rule.figure_maker)) + " -> " + name +
                 " [style=dotted, label=" + quoted(rule.rule.figure.port) + "];\n";
    for (const MeasuredParameter& parameter : task.measured)
      edges += "    " + quoted(graph.nameOf(parameter.maker)) + " -> " + name +
               " [style=dotted, label=" + quoted(parameter.figure.port) + "];\n";
    for (const auto& [port, input] : task.inputs) {
      const std::string from = input.maker ? graph.nameOf(*input.maker) : input.file.string();
      if (!input.maker) nodes += "    " + quoted(from) + " [shape=note];\n";
      edges += "    " + quoted(from) + " -> " + name + " [label=" + quoted(port) + "];\n";
    }
    for (const auto& [port, deliverable] : task.deliverables) {
      const std::string file = quoted(graph.assets[asset].name + "/" + task.outputs.at(port));
      nodes += "    " + file + " [shape=note, style=bold];\n";
      edges += "    " + name + " -> " + file + ";\n";
    }
  }
  return "  subgraph " + quoted("cluster_" + graph.assets[asset].name) +
         " {\n    label=" + quoted(graph.assets[asset].name) + ";\n" + nodes + edges + "  }\n";
}

}  // namespace

std::string toDot(const Graph& graph) {
  std::string dot = "digraph bakelight {\n  rankdir=LR;\n  node [shape=box];\n";
  for (std::size_t asset = 0; asset < graph.assets.size(); ++asset) dot += assetToDot(graph, asset);
  return dot + "}\n";
}

std::string toText(const Graph& graph) {
  std::string text;
  for (TaskIndex index = 0; index < graph.tasks.size(); ++index) {
    const Task& task = graph.tasks[index];
    text += graph.nameOf(index);
    const char* separator = " <- ";
    for (const auto& [port, input] : task.inputs) {
      text += separator + originOf(graph, input);
      separator = ", ";
    }
    for (const TaskRule& rule : task.rules) {
      text += separator + rule.rule.figure.text();
      separator = ", ";
    }
    for (const MeasuredParameter& parameter : task.measured) {
      text += separator + parameter.figure.text();
      separator = ", ";
    }
    for (const auto& [port, deliverable] : task.deliverables) text += " -> " + task.outputs.at(port);
    if (!task.left_out.empty()) text += " (left out: " + task.left_out + ")";
    if (const std::string figures = omittedIf(task); !figures.empty())
      text += " (left out if " + figures + ")";
    text += "\n";
  }
  return text;
}

Json toJson(const Graph& graph) {
  Json stages = Json::array();
  for (const Task& task : graph.tasks) {
    Json inputs = Json::object();
    for (const auto& [port, input] : task.inputs) inputs[port] = originOf(graph, input);
    Json measured = Json::object();
    for (const MeasuredParameter& parameter : task.measured)
      measured[parameter.name] = parameter.figure.text();
    stages.push_back({{"asset", graph.assets[task.asset].name},
                      {"stage", task.stage},
                      {"tool", task.tool},
                      {"inputs", std::move(inputs)},
                      {"outputs", task.outputs},
                      {"deliverables", task.deliverables},
                      {"parameters", task.parameters},
                      {"measured", std::move(measured)},
                      {"left_out", task.left_out},
                      {"left_out_if", omittedIf(task)}});
  }
  return {{"stages", std::move(stages)}};
}

}  // namespace bakelight::pipeline
