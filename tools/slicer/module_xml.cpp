#include "tools/slicer/module_xml.h"

#include "tools/job/option_values.h"

#include <cmath>

namespace slicemorph {
namespace {

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

std::string element(const std::string& indent, const std::string& name, const std::string& text) {
  return indent + "<" + name + ">" + escaped(text) + "</" + name + ">\n";
}

std::string tagOf(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::kVolume:
    case ParameterKind::kLabelMap:
      return "image";
    case ParameterKind::kModel:
      return "geometry";
    case ParameterKind::kPoints:
      return "point";
    case ParameterKind::kFile:
      return "file";
    case ParameterKind::kFolder:
      return "directory";
    case ParameterKind::kFlag:
      return "boolean";
    case ParameterKind::kInteger:
      return "integer";
    case ParameterKind::kNumber:
      return "double";
    case ParameterKind::kChoice:
      return "string-enumeration";
    case ParameterKind::kText:
    case ParameterKind::kRemark:
      break;
  }
  return "string";
}

/// Slicer offers scalar volumes and label maps for `scalar`, label maps and segmentations for `label`. It gives points in
/// LPS, as everything else is in files.
std::string attributesOf(const ModuleParameter& parameter) {
  std::string text, extensions;
  if (parameter.kind == ParameterKind::kVolume) text += " type=\"scalar\"";
  if (parameter.kind == ParameterKind::kLabelMap) text += " type=\"label\"";
  if (parameter.kind == ParameterKind::kModel) text += " type=\"model\"";
  for (const std::string& extension : parameter.extensions)
    extensions += (extensions.empty() ? "" : ",") + extension;
  if (!extensions.empty()) text += " fileExtensions=\"" + extensions + "\"";
  if (parameter.kind == ParameterKind::kPoints) text += " multiple=\"true\" coordinateSystem=\"lps\"";
  if (!parameter.beside.empty()) text += " reference=\"" + parameter.beside + "\"";
  return text;
}

bool hasChannel(ParameterKind kind) {
  return kind <= ParameterKind::kFolder || kind == ParameterKind::kRemark;
}

/// Limits become a slider, which needs both ends.
std::string constraintsOf(const ModuleParameter& parameter) {
  if (!std::isfinite(parameter.range.least) || !std::isfinite(parameter.range.most)) return "";
  const std::string indent = "        ";
  return "      <constraints>\n" + element(indent, "minimum", formatNumber(parameter.range.least, 9)) +
         element(indent, "maximum", formatNumber(parameter.range.most, 9)) +
         element(indent, "step", formatNumber(parameter.step)) + "      </constraints>\n";
}

std::string xmlOf(const ModuleParameter& parameter) {
  const std::string tag = tagOf(parameter.kind), indent = "      ";
  std::string xml = "    <" + tag + attributesOf(parameter) + ">\n" + element(indent, "name", parameter.name);
  // What a module answers has no flag: it is in the file that --returnparameterfile names.
  if (parameter.kind != ParameterKind::kRemark) xml += element(indent, "longflag", "--" + parameter.name);
  xml += element(indent, "description", parameter.help) + element(indent, "label", parameter.label);
  if (!parameter.value.empty()) xml += element(indent, "default", parameter.value);
  if (hasChannel(parameter.kind)) xml += element(indent, "channel", parameter.output ? "output" : "input");
  for (const std::string& choice : parameter.choices) xml += element(indent, "element", choice);
  return xml + constraintsOf(parameter) + "    </" + tag + ">\n";
}

std::string xmlOf(const ParameterGroup& group) {
  std::string xml = std::string("  <parameters") + (group.advanced ? " advanced=\"true\"" : "") + ">\n" +
                    element("    ", "label", group.label) + element("    ", "description", group.help);
  for (const ModuleParameter& parameter : group.parameters) xml += xmlOf(parameter);
  return xml + "  </parameters>\n";
}

}  // namespace

std::string xmlOf(const SlicerModule& module) {
  const std::string indent = "  ";
  std::string xml = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<executable>\n" +
                    element(indent, "category", "Slicemorph") + element(indent, "title", module.title) +
                    element(indent, "description", module.description) +
                    element(indent, "version", SLICEMORPH_VERSION) +
                    element(indent, "documentation-url", "") + element(indent, "license", "Apache-2.0") +
                    element(indent, "contributor", "slicemorph");
  for (const ParameterGroup& group : module.groups) xml += xmlOf(group);
  return xml + "</executable>\n";
}

}  // namespace slicemorph
