#include "tools/job/render_shots.h"

#include "io/paths.h"
#include "io/sequence.h"
#include "io/vdb/fog_reader.h"
#include "tools/job/option_values.h"

#include <filesystem>

namespace slicemorph {
namespace {

constexpr size_t kMostBytes = size_t(1) << 30;  // of grids that are kept, a bound of memory

size_t bytesOf(const RenderSubject& subject) {
  size_t bytes = subject.surface ? subject.surface->memUsage() : 0;
  if (!subject.fog) return bytes;
  bytes += subject.fog->density->memUsage();
  if (subject.fog->heat) bytes += subject.fog->heat->memUsage();
  if (subject.fog->colour) bytes += subject.fog->colour->memUsage();
  return bytes;
}

}  // namespace

std::vector<RenderInput> listRenderInputs(const std::vector<std::string>& inputs, const HeldInputs& held) {
  std::vector<RenderInput> list;
  for (size_t k = 0; k < inputs.size(); ++k) {
    const std::string& input = inputs[k];
    if (heldAt(held, k)) {
      list.push_back({input, input, 1, false, held[k]});
    } else if (isMovingInput(input)) {
      for (const InputFrame& frame : framesOf(parseInput(input)))
        list.push_back({frame.input.text, std::to_string(frame.number), frame.number, true});
    } else {
      checkInputExists(input);
      list.push_back({input, std::filesystem::path(input).stem().string(), 1, false});
    }
  }
  // A single input keeps its own numbers; several are counted.
  if (inputs.size() > 1)
    for (size_t i = 0; i < list.size(); ++i) list[i].number = int(i) + 1;
  return list;
}

RenderSubjects::RenderSubjects(const std::vector<RenderInput>& inputs, const LoadOptions& load,
                               bool asSurface)
    : inputs_(inputs), load_(load), asSurface_(asSurface), kept_(inputs.size()) {}

RenderSubject RenderSubjects::get(size_t input) {
  if (kept_[input]) return *kept_[input];
  const RenderSubject subject = read(input);
  const size_t bytes = bytesOf(subject);
  if (keptBytes_ + bytes < kMostBytes) {
    keptBytes_ += bytes;
    kept_[input] = subject;
  }
  return subject;
}

RenderSubject RenderSubjects::read(size_t input) const {
  const HeldInput* const held = inputs_[input].held.get();
  const InputSpec spec = held ? held->spec : parseInput(inputs_[input].path);
  RenderSubject subject;
  try {
    if (!asSurface_ && spec.isGrids())
      subject.fog =
          held ? readFog(*std::get<std::shared_ptr<const VdbFile>>(held->content), spec) : readFog(spec);
    if (subject.fog) return subject;
    LoadedObject object = held ? loadObject(*held, load_) : loadObject(spec, load_);
    subject.surface = object.object.levelSet;
    subject.colors = object.colors;
  } catch (const NothingError&) {
    if (!inputs_[input].moving) throw;
  }
  return subject;
}

}  // namespace slicemorph
