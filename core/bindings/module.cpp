// The Python module omnimorph._core: thin doors onto the headers, nothing computed here.
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>

#include "bind.hpp"

NB_MODULE(_core, m) {
    m.doc() = "The compiled core of omnimorph; its documented face is omnimorph.model, control and simulation.";
    nanobind::set_leak_warnings(false);
    omnimorph::python::bind_model(m);
    omnimorph::python::bind_plant(m);
    omnimorph::python::bind_loop(m);
    omnimorph::python::bind_analysis(m);
    omnimorph::python::bind_processor(m);
}
