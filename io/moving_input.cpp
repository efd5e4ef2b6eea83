#include "io/moving_input.h"

#include "io/sequence.h"
#include "io/vdb/grid_choice.h"

#include <algorithm>

namespace slicemorph {
namespace {

enum : char { kNotRead, kNothing, kSomething };

/// Whether a VDB file has the grid that an input names, or, where it names none, any scalar one: simulations leave out
/// grids that are empty.
bool hasGrid(const InputSpec& input) {
  const VdbFile file(input.path);
  const std::string& name = input.selection;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const std::string& own = file.entries()[i].name;
    if (!name.empty() && own != name && own != name + "[0]") continue;
    const openvdb::GridBase::Ptr header = file.readHeader(i);
    if (!name.empty() || (header && isScalar(*header))) return true;
  }
  return false;
}

}  // namespace

MovingInput::MovingInput(const InputSpec& input) : input_(input), moves_(input.isMoving()) {
  if (!moves_) {
    files_.push_back(input);
  } else {
    std::vector<SequenceFile> numbers;
    for (InputFrame& frame : framesOf(input)) {
      numbers.push_back({frame.number, frame.input.path});
      files_.push_back(std::move(frame.input));
    }
    if (input.range.empty()) missing_ = missingNumbers(numbers);
  }
  full_.assign(files_.size(), kNotRead);
}

Notes MovingInput::notes() const {
  if (missing_.empty()) return {};
  return {{"sequence.missing", Severity::kWarning, input_.text,
           (missing_.size() == 1 ? "frame " : "frames ") + listOfNumbers(missing_) +
               (missing_.size() == 1 ? " is" : " are") +
               " missing: the files that are there follow each other"}};
}

std::optional<LoadedObject> MovingInput::tried(size_t n, const LoadOptions& options) {
  if (full_[n] == kNothing) return std::nullopt;
  if (piece_ && pieceAt_ == n) return piece_;
  InputSpec file = files_[n];
  const bool named = !file.selection.empty();
  if (!named) file.selection = grid_;
  full_[n] = kNothing;
  if (file.isGrids() && !hasGrid(file)) return std::nullopt;
  try {
    LoadedObject loaded = loadObject(file, options);
    loaded.named = named;
    full_[n] = kSomething;
    return loaded;
  } catch (const NothingError&) {
    return std::nullopt;
  } catch (...) {
    full_[n] = kNotRead;
    throw;
  }
}

void MovingInput::refuseAsNothing(const LoadOptions& options) const {
  loadObject(files_[0], options);  // says why the first is nothing
  throw NothingError(input_.text, "none of its " + std::to_string(files_.size()) + " files holds anything");
}

void MovingInput::chooseGrid(const LoadOptions& options) {
  if (chosen_) return;
  LoadOptions first = options;
  if (input_.isGrids()) first.besides.push_back(files_.back().path);
  // In the first files there may be nothing but what stands still.
  for (bool movingOnly : {true, false}) {
    first.movingOnly = movingOnly;
    full_.assign(files_.size(), kNotRead);
    for (size_t n = 0; n < files_.size(); ++n) {
      std::optional<LoadedObject> loaded = tried(n, first);
      if (!loaded) continue;
      if (loaded->file) grid_ = loaded->file->entries()[loaded->grid].name;
      piece_ = std::move(loaded), pieceAt_ = n;
      chosen_ = true;
      return;
    }
  }
  refuseAsNothing(options);
}

const LoadedObject& MovingInput::pieceFor(size_t n, const LoadOptions& options) {
  const auto take = [&](size_t i) {
    std::optional<LoadedObject> loaded = tried(i, options);
    if (!loaded) return false;
    piece_ = std::move(loaded), pieceAt_ = i;
    return true;
  };
  for (size_t i = n; i-- > 0;)
    if (take(i)) return *piece_;
  for (size_t i = n + 1; i < files_.size(); ++i)
    if (take(i)) return *piece_;
  refuseAsNothing(options);
}

LoadedObject MovingInput::load(size_t frame, const LoadOptions& options) {
  const size_t n = std::min(frame, files_.size() - 1);
  if (!moves_) return loadObject(files_[n], options);
  if (input_.isGrids() && input_.selection.empty()) chooseGrid(options);
  if (std::optional<LoadedObject> loaded = tried(n, options)) {
    piece_ = loaded, pieceAt_ = n;
    return *loaded;
  }
  LoadedObject nothing = asNothing(pieceFor(n, options), files_[n]);
  nothing.notes.emplace_back(
      "sequence.nothing", Severity::kNote, "",
      "holds nothing: what is there grows out of, or went into, " + files_[pieceAt_].path);
  return nothing;
}

}  // namespace slicemorph
