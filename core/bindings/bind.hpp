// The parts of the module, one function a file.
#pragma once

#include "arrays.hpp"
#include "loop.hpp"

namespace omnimorph::python {

void bind_model(nb::module_& m);
void bind_plant(nb::module_& m);
void bind_loop(nb::module_& m);
void bind_analysis(nb::module_& m);
void bind_processor(nb::module_& m);

}  // namespace omnimorph::python
