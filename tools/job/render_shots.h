#pragma once

#include "engine/render/render_fog.h"
#include "tools/job/job_options.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// What is rendered: a surface, or fog; neither, where a file of a sequence holds nothing.
struct RenderSubject {
  FloatGrid::ConstPtr surface;
  openvdb::Vec3SGrid::ConstPtr colors;  ///< of the surface; null: it has none
  std::optional<Fog> fog;
};

/// A file to render.
struct RenderInput {
  std::string path;  ///< with the name of the grid if one is given
  std::string caption;
  int number = 1;                                   ///< in the only sequence; else counted
  bool moving = false;                              ///< of a sequence: it may hold nothing
  std::shared_ptr<const HeldInput> held = nullptr;  ///< where it is in memory
};
/// The files of all inputs, those of numbered sequences by their numbers. Throws IoError for missing files.
std::vector<RenderInput> listRenderInputs(const std::vector<std::string>& inputs, const HeldInputs& held);

/// Reads what is rendered. Each input is needed twice, for the camera and for the picture; it is read again
/// where there is too much to keep in memory.
class RenderSubjects {
 public:
  /// `asSurface`: fog is drawn as the shape in it.
  RenderSubjects(const std::vector<RenderInput>& inputs, const LoadOptions& load, bool asSurface);
  /// Throws as loadObject and readFog.
  RenderSubject get(size_t input);

 private:
  RenderSubject read(size_t input) const;

  const std::vector<RenderInput>& inputs_;
  const LoadOptions& load_;
  bool asSurface_;
  std::vector<std::optional<RenderSubject>> kept_;
  size_t keptBytes_ = 0;
};

}  // namespace slicemorph
