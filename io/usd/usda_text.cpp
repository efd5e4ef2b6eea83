#include "io/usd/usda_text.h"

#include <filesystem>

namespace slicemorph {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

std::string numberText(double value) {
  std::string text;
  addNumber(text, value);
  return text;
}

std::string withReplaced(std::string text, const std::string& what, const std::string& by) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

}  // namespace

std::string usdaHeader(const UsdaStage& stage, const std::string& defaultPrim,
                       const std::optional<std::pair<int, int>>& frames) {
  const std::string perSecond = numberText(stage.framesPerSecond);
  std::string text = "#usda 1.0\n(\n    defaultPrim = \"" + defaultPrim + "\"\n";
  if (frames)
    text +=
        "    endTimeCode = " + std::to_string(frames->second) + "\n    framesPerSecond = " + perSecond + "\n";
  text += "    metersPerUnit = " + numberText(stage.metres) + "\n";
  if (frames)
    text += "    startTimeCode = " + std::to_string(frames->first) +
            "\n    timeCodesPerSecond = " + perSecond + "\n";
  return text + "    upAxis = \"" + (stage.zUp ? "Z" : "Y") + "\"\n)\n\n";
}

std::string usdaName(const std::string& text) {
  std::string name;
  for (const char c : text) name += isLetter(c) || isDigit(c) ? c : '_';
  return name.empty() || isDigit(name[0]) ? "_" + name : name;
}

std::string usdaNameOfFile(const std::string& path) {
  return usdaName(std::filesystem::path(path).stem().string());
}

std::string usdaString(const std::string& text) {
  // A quote that the text does not hold needs no escape, which some readers do not know.
  const bool single = text.find('"') != std::string::npos && text.find('\'') == std::string::npos;
  const std::string quote(1, single ? '\'' : '"');
  std::string inner = withReplaced(withReplaced(text, "\\", "\\\\"), "\n", "\\n");
  if (!single) inner = withReplaced(std::move(inner), "\"", "\\\"");
  return quote + inner + quote;
}

std::string usdaAsset(const std::string& file) {
  if (file.find('@') == std::string::npos) return "@./" + file + "@";
  return "@@@./" + withReplaced(file, "@@@", "\\@@@") + "@@@";
}

std::string usdaExtent(const openvdb::BBoxd& box) {
  if (box.empty()) return "None";
  std::string text = "[";
  addVector(text, openvdb::Vec3s(box.min())), text += ", ", addVector(text, openvdb::Vec3s(box.max()));
  return text + "]";
}

}  // namespace slicemorph
