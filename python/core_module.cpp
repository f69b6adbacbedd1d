// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, pcl_ssfr contributors

#include "bindings.h"

#include <pcl_ssfr/version.h>

#include <apps/io/io_error.h>

#include <exception>
#include <utility>

namespace py = pybind11;

/// pcl_ssfr._core: what pcl_ssfr/__init__.py is a face of. std::invalid_argument is ValueError.
PYBIND11_MODULE(_core, module)
{
  module.doc() = "The compiled part of pcl_ssfr; use pcl_ssfr.";
  module.attr("__version__") = PCL_SSFR_VERSION;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown)
        std::rethrow_exception(std::move(thrown));
    }
    catch (const pcl_ssfr::io::IoError& error) {
      const py::object type = py::module_::import("pcl_ssfr._enums").attr("FileError");
      PyErr_SetString(type.ptr(), error.what());
    }
  });
  pcl_ssfr::python::bindPairs(module);
  pcl_ssfr::python::bindFiles(module);
#ifdef PCL_SSFR_PYTHON_MAPS
  pcl_ssfr::python::bindMaps(module);
#endif
}
