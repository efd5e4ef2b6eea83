#include "tools/python/errors.h"

#include "slicemorph/errors.h"
#include "slicemorph/io/memory.h"

#include <new>

namespace slicemorph {
namespace {

namespace py = pybind11;

/// Sets Python's exception of that class.
void raise(const char* name, const Error& error) {
  const Note& note = error.note();
  const py::object type = py::module_::import("slicemorph._errors").attr(name);
  const py::object value = type(note.text, note.about, note.code);
  PyErr_SetObject(type.ptr(), value.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Cancelled& error) {
    raise("Cancelled", error);
  } catch (const MemoryError& error) {
    raise("OutOfMemory", error);
  } catch (const IoError& error) {
    raise("IoError", error);
  } catch (const GeometryError& error) {
    raise("GeometryError", error);
  } catch (const InputError& error) {
    raise("InputError", error);
  } catch (const Error& error) {
    raise("Error", error);
  } catch (const std::bad_alloc&) {
    raise("OutOfMemory",
          Error("there is not enough memory: choose a larger voxel_size or a smaller resolution"));
  }
}

}  // namespace

void addErrors() { py::register_local_exception_translator(translate); }

}  // namespace slicemorph
