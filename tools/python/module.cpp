#include "slicemorph/io/vdb_reader.h"
#include "slicemorph/note.h"
#include "tools/python/commands.h"
#include "tools/python/errors.h"
#include "tools/python/grid.h"
#include "tools/python/input.h"
#include "tools/python/plan.h"

/// The part of the package that is compiled; slicemorph/*.py make the interface of it.
PYBIND11_MODULE(_core, module) {
  using namespace slicemorph;
  initialiseVdb();
  addErrors();
  const auto severityOf = [](const Note& note) {
    const char* const names[] = {"detail", "note", "warning", "error"};
    return names[int(note.severity)];
  };
  py::class_<Note>(module, "Note", "Something that was found, decided or changed.")
      .def_readonly("code", &Note::code, "A stable name: \"mesh.holes-closed\".")
      .def_readonly("about", &Note::about, "The file, grid, option or object; empty: the whole job.")
      .def_readonly("text", &Note::text, "One sentence, without its subject in front.")
      .def_property_readonly("severity", severityOf, "\"detail\", \"note\", \"warning\".")
      .def("__str__", &Note::sentence)
      .def("__repr__", [](const Note& note) { return "<Note " + note.code + ": " + note.sentence() + ">"; });
  addGrid(module);
  addInput(module);
  addPlan(module);
  addCommands(module);
  module.attr("__version__") = SLICEMORPH_VERSION;
}
