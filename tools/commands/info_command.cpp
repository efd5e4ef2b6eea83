#include "tools/commands/info_command.h"

#include "engine/numerics/readable.h"
#include "slicemorph/io/file_info.h"
#include "slicemorph/io/input.h"
#include "tools/commands/command_options.h"
#include "tools/job/load_settings.h"
#include "tools/job/option_values.h"

#include <nlohmann/json.hpp>

#include <cstdio>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Vec3d& v) { return {v[0], v[1], v[2]}; }
std::string toText(const Vec3d& v) {
  return formatNumber(v[0]) + " " + formatNumber(v[1]) + " " + formatNumber(v[2]);
}

Json describeMesh(const MeshInfo& m) {
  return {{"points", m.points},
          {"faces", m.faces},
          {"shells", m.shells},
          {"closed", m.closed},
          {"boundaryEdges", m.boundaryEdges},
          {"boundaryLoops", m.boundaryLoops},
          {"nonManifoldEdges", m.nonManifoldEdges},
          {"box", {toJson(m.boxMin), toJson(m.boxMax)}},
          {"signedVolume", m.signedVolume},
          {"colors", m.colors},
          {"notes", sentencesOf(m.notes)},
          {"problem", m.problem}};
}

Json describeGrid(const GridInfo& g) {
  Json json = {{"name", g.name},
               {"type", g.type},
               {"class", g.gridClass},
               {"activeVoxels", g.activeVoxels},
               {"voxelSize", toJson(g.voxelSize)},
               {"rotated", g.rotated},
               {"uniform", g.uniform},
               {"box", {toJson(g.boxMin), toJson(g.boxMax)}},
               {"halfFloat", g.halfFloat}};
  if (g.scalar) {
    json["background"] = g.background;
    json["minimum"] = g.minimum;
    json["maximum"] = g.maximum;
  }
  json["reading"] = g.reading;
  json["problem"] = g.problem;
  return json;
}

Json describeImage(const ImageInfo& i) {
  return {{"name", i.name},
          {"format", i.format},
          {"about", i.about},
          {"type", i.type.empty() ? Json() : Json(i.type)},
          {"size", {i.size[0], i.size[1], i.size[2]}},
          {"spacing", i.placed ? toJson(i.spacing) : Json()},
          {"origin", i.placed ? toJson(i.origin) : Json()},
          {"axes", i.placed ? Json{toJson(i.axes[0]), toJson(i.axes[1]), toJson(i.axes[2])} : Json()},
          {"volumes", i.volumes},
          {"minimum", i.looked ? Json(i.minimum) : Json()},
          {"maximum", i.looked ? Json(i.maximum) : Json()},
          {"labels", i.looked ? Json(i.labels) : Json()},
          {"reading", i.reading},
          {"notes", sentencesOf(i.notes)}};
}

Json describeStructure(const StructureInfo& s) {
  return {{"number", s.number},
          {"name", s.name},
          {"planes", s.planes},
          {"contours", s.contours},
          {"gapMm", {{"usual", s.gap}, {"least", s.gapMin}, {"most", s.gapMax}}},
          {"volumeMl", s.volume ? Json(*s.volume / 1000) : Json(nullptr)},
          {"box", {toJson(s.boxMin), toJson(s.boxMax)}}};
}

void printJson(const FileInfo& info) {
  Json json = {{"file", info.path}, {"format", info.format}, {"bytes", info.bytes}};
  if (info.contents == Contents::kImage) {
    json["images"] = Json::array();
    for (const ImageInfo& image : info.images) json["images"].push_back(describeImage(image));
  } else if (info.contents == Contents::kContours) {
    json["structures"] = Json::array();
    for (const StructureInfo& one : info.structures) json["structures"].push_back(describeStructure(one));
    json["notes"] = sentencesOf(info.notes);
  } else if (info.contents == Contents::kMesh) {
    json["mesh"] = describeMesh(info.mesh);
  } else {
    json["fileVersion"] = info.vdb.fileVersion;
    json["libraryVersion"] = info.vdb.libraryVersion;
    json["chosen"] = info.vdb.chosen;
    json["why"] = info.vdb.why;
    json["grids"] = Json::array();
    for (const GridInfo& grid : info.vdb.grids) json["grids"].push_back(describeGrid(grid));
  }
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void printLine(const char* name, const std::string& value) {
  std::printf("  %-13s %s\n", name, value.c_str());
}

void printMesh(const MeshInfo& m) {
  printLine("points", readableCount(double(m.points)));
  printLine("faces", readableCount(double(m.faces)));
  printLine("shells", readableCount(double(m.shells)));
  printLine("closed", m.closed ? "yes"
                               : "no: " + readableCount(double(m.boundaryEdges)) + " boundary edges in " +
                                     readableCount(double(m.boundaryLoops)) + " loops, " +
                                     readableCount(double(m.nonManifoldEdges)) + " non-manifold edges");
  printLine("box", toText(m.boxMin) + " .. " + toText(m.boxMax));
  if (m.closed) printLine("volume", formatNumber(m.signedVolume));
  if (!m.colors.empty()) printLine("colours", "of its " + m.colors);
  for (const Note& note : m.notes) printLine("on reading", note.sentence());
  if (!m.problem.empty()) printLine("problem", m.problem);
}

void printGrid(const GridInfo& g, bool chosen, const std::string& why) {
  std::printf("grid %s%s\n", g.name.c_str(), chosen ? " (read when none is named)" : "");
  printLine("type", g.type + ", " + g.gridClass + (g.halfFloat ? ", half float" : ""));
  printLine("active voxels", readableCount(double(g.activeVoxels)));
  printLine("voxel size",
            toText(g.voxelSize) + (g.rotated ? ", rotated" : "") + (g.uniform ? "" : ", not uniform"));
  printLine("box", toText(g.boxMin) + " .. " + toText(g.boxMax));
  if (g.scalar)
    printLine("values", formatNumber(g.minimum) + " .. " + formatNumber(g.maximum) + ", background " +
                            formatNumber(g.background));
  if (!g.reading.empty()) printLine("read as", g.reading);
  if (chosen && !why.empty()) printLine("chosen as", why);
  if (!g.problem.empty()) printLine("problem", g.problem);
}

/// How many voxels an image has, where they are too many to be multiplied in the head: " (9.8 million)".
std::string countOf(const ImageInfo& i) {
  const double count = double(i.size[0]) * double(i.size[1]) * double(i.size[2]);
  return count < 1e6 ? "" : " (" + readableCount(count) + ")";
}

void printImage(const ImageInfo& i) {
  std::printf("image %s%s%s\n", i.name.c_str(), i.about.empty() ? "" : ": ", i.about.c_str());
  printLine("voxels", std::to_string(i.size[0]) + " x " + std::to_string(i.size[1]) + " x " +
                          std::to_string(i.size[2]) + countOf(i) + (i.type.empty() ? "" : ", " + i.type) +
                          (i.volumes > 1 ? ", one of " + std::to_string(i.volumes) + " volumes" : ""));
  if (i.placed) {
    printLine("spacing", toText(i.spacing) + " mm");
    printLine("origin", toText(i.origin) + " (LPS)");
    for (int d = 0; d < 3; ++d) printLine(d == 0 ? "axes" : "", toText(i.axes[d]));
  }
  if (i.looked) printLine("values", formatNumber(i.minimum) + " .. " + formatNumber(i.maximum));
  printLine("read as", i.reading);
  for (const Note& note : i.notes) printLine("on reading", note.sentence());
}

void printStructure(const StructureInfo& s) {
  std::printf("structure %d '%s'\n", s.number, s.name.c_str());
  if (s.planes == 0) return printLine("planes", "none: it has no closed contour");
  std::string gaps;
  if (s.volume) {
    gaps = ", " + formatNumber(s.gap) + " mm apart";
    if (s.gapMax - s.gapMin > 0.01 * s.gap)
      gaps += " (" + formatNumber(s.gapMin) + " to " + formatNumber(s.gapMax) + ")";
  } else if (s.planes > 1) {
    gaps = ", in several directions";
  }
  printLine("planes", std::to_string(s.planes) + gaps);
  printLine("contours", readableCount(double(s.contours)));
  printLine("volume", s.volume ? formatNumber(*s.volume / 1000) + " ml, between the contours' planes as slabs"
                               : "not told by slabs: `slicemorph reconstruct --report` measures it");
  printLine("box", toText(s.boxMin) + " .. " + toText(s.boxMax));
}

void printText(const FileInfo& info) {
  std::printf("%s: %s, %s", info.path.c_str(), info.format.c_str(),
              readableBytes(double(info.bytes)).c_str());
  if (info.contents == Contents::kMesh) {
    std::printf("\n");
    printMesh(info.mesh);
    return;
  }
  if (info.contents == Contents::kContours) {
    std::printf("\n");
    for (const StructureInfo& one : info.structures) printStructure(one);
    for (const Note& note : info.notes) printLine("on reading", note.sentence());
    return;
  }
  if (info.contents == Contents::kImage) {
    std::printf("\n");
    for (const ImageInfo& image : info.images) printImage(image);
    return;
  }
  std::printf(", file version %u, written by OpenVDB %s\n", info.vdb.fileVersion,
              info.vdb.libraryVersion.c_str());
  for (const GridInfo& grid : info.vdb.grids) printGrid(grid, grid.name == info.vdb.chosen, info.vdb.why);
}

}  // namespace

void addInfoCommand(CLI::App& program) {
  CLI::App* command = program.add_subcommand("info", "What a file holds, and how it will be read");
  const auto options = addOptions(*command, kInfo);
  command->callback([options] {
    const JobOptions& given = options->values();
    const LoadOptions load = loadSettings(*options);
    load.memory.enforce();
    const FileInfo info = describeFile(parseInput(given.input), load.image);
    if (given.json)
      printJson(info);
    else
      printText(info);
  });
}

}  // namespace slicemorph
