#pragma once

#include <string>
#include <utility>

#include <pybind11/pybind11.h>

#include "t4d/error.h"

namespace t4d::python {

namespace py = pybind11;

/// Raises the Python exception for an error (t4d/errors.py). Needs the GIL.
[[noreturn]] inline void raise(const Error& error) {
  static constexpr const char* kNames[] = {"InvalidInput", "FileError", "Unsupported", "Failed",
                                           "InvalidInput"};
  const py::object type =
      py::module_::import("t4d.errors").attr(kNames[static_cast<int>(error.code)]);
  const py::object offset = error.offset ? py::object(py::int_(*error.offset)) : py::none();
  // They may name a file whose name is not UTF-8.
  const auto text = [](const std::string& bytes) {
    const auto size = static_cast<Py_ssize_t>(bytes.size());
    return py::reinterpret_steal<py::object>(PyUnicode_DecodeFSDefaultAndSize(bytes.data(), size));
  };
  const Place& where = error.where;
  const Place line = placeIn({}, where.line == 0 ? "" : std::to_string(where.line));
  const py::object raised = type(text(error.message), text(where.text()), offset, text(where.file),
                                 text(placeIn(line, where.part).part));
  PyErr_SetObject(type.ptr(), raised.ptr());
  throw py::error_already_set();
}

/// The value, or the exception. Needs the GIL.
template <class T>
T valueOf(Result<T> result) {
  if (!result) raise(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace t4d::python
