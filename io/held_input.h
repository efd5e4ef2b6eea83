#pragma once

#include "io/mesh/mesh_reader.h"
#include "slicemorph/io/input.h"

#include <memory>
#include <string>
#include <variant>

namespace slicemorph {

/// An input that is in memory: made there, or read before it is known what it is for. Its content is shared and never
/// changed.
struct HeldInput {
  InputSpec spec;  ///< of what was read the file's; else made by heldSpec()
  std::variant<std::shared_ptr<const StoredMesh>, std::shared_ptr<const ImageFile>,
               std::shared_ptr<const VdbFile>>
      content;
};

/// The description of an input that no file holds. `name`: for messages and reports.
InputSpec heldSpec(const std::string& name, Contents contents);

/// Reads a still mesh, image or VDB file (of this only its table of contents, and each grid when it is needed). Throws as
/// the readers of these, and InputError for what is none of them.
HeldInput holdInput(const InputSpec& input, const ImageOptions& options = {});

/// As loadObject of a file with this content.
LoadedObject loadObject(const HeldInput& input, const LoadOptions& options = {});

}  // namespace slicemorph
