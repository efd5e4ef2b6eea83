#include "tools/report/pick_part.h"

#include "tools/report/page_template.h"

#include <algorithm>
#include <cstdint>

namespace slicemorph {
namespace {

using Json = nlohmann::ordered_json;

Json jsonOf(const Vec3d& v) { return {v[0], v[1], v[2]}; }

Json jsonOf(const std::vector<Vec3d>& positions) {
  Json list = Json::array();
  for (const Vec3d& p : positions) list.push_back(jsonOf(p));
  return list;
}

Json jsonOf(const PickShape& shape) {
  Json json = {{"name", shape.name},
               {"origin", jsonOf(shape.mesh.origin)},
               {"points", shape.mesh.points.size()},
               {"triangles", shape.mesh.triangles.size()},
               {"colors", !shape.mesh.colors.empty()},
               {"limbs", Json::array()}};
  for (const PickLimb& limb : shape.limbs)
    json["limbs"].push_back({{"line", jsonOf(limb.line)}, {"group", limb.group}});
  return json;
}

Json jsonOf(const Feature& feature) {
  const char* kinds[] = {"point", "line", "disk"};
  Json json = {{"name", feature.name}, {"kind", kinds[int(feature.kind)]}, {"positions", Json::array()}};
  for (const std::vector<Vec3d>& ofShape : feature.positions) json["positions"].push_back(jsonOf(ofShape));
  if (feature.kind != Feature::Kind::kDisk) return json;
  json["normals"] = jsonOf(feature.normals);
  json["radii"] = feature.radii;
  return json;
}

/// Appends numbers as they lie in memory; the page reads little-endian ones, which all supported machines have.
template <typename Vector>
void append(std::string& bytes, const std::vector<Vector>& vectors) {
  static_assert(sizeof(Vector) == 12, "three numbers of four bytes");
  bytes.append(reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(Vector));
}

void appendColors(std::string& bytes, const std::vector<openvdb::Vec3s>& colors) {
  for (const openvdb::Vec3s& color : colors) {
    for (int c = 0; c < 3; ++c) bytes += char(std::uint8_t(255 * std::clamp(color[c], 0.f, 1.f) + 0.5f));
    bytes += char(255);
  }
}

/// Per shape: points, triangles, where the points go on each other shape, colours of four bytes.
std::string meshBytes(const PickScene& scene) {
  std::string bytes;
  for (const PickShape& shape : scene.shapes) {
    append(bytes, shape.mesh.points);
    append(bytes, shape.mesh.triangles);
    for (const std::vector<openvdb::Vec3s>& points : shape.meets) append(bytes, points);
    appendColors(bytes, shape.mesh.colors);
  }
  return bytes;
}

}  // namespace

std::string pickPart(const PickScene& scene, const PickTexts& texts) {
  Json json = {{"file", texts.file},        {"job", texts.job},
               {"up", jsonOf(scene.up)},    {"overlap", scene.overlap ? Json(*scene.overlap) : Json(nullptr)},
               {"turns", Json::array()},    {"shapes", Json::array()},
               {"features", Json::array()}, {"landmarks", Json::array()},
               {"notes", texts.notes}};
  for (const TurnChoice& turn : scene.turns)
    json["turns"].push_back({{"degrees", turn.degrees}, {"margin", turn.margin}});
  for (const PickShape& shape : scene.shapes) json["shapes"].push_back(jsonOf(shape));
  for (const Feature& feature : texts.features) json["features"].push_back(jsonOf(feature));
  for (const std::vector<Vec3d>& landmark : texts.landmarks) json["landmarks"].push_back(jsonOf(landmark));
  return pageData("pick", json) + pageData("pickMeshes", "text/plain", base64Of(meshBytes(scene)));
}

}  // namespace slicemorph
