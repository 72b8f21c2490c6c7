// What the processor can do: the instruction sets for which batches are compiled, the best last.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"

namespace omnimorph::python {

namespace {

std::vector<std::string> instruction_sets() {
#if defined(__x86_64__)
    std::vector<std::string> known{"x86-64-v2"};
    const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    const bool has_v4 = has_v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512cd") &&
                        __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
    if (has_v3) known.push_back("x86-64-v3");
    if (has_v4) known.push_back("x86-64-v4");
    return known;
#else
    return {"portable"};
#endif
}

}  // namespace

void bind_processor(nb::module_& m) { m.def("instruction_sets", &instruction_sets); }

}  // namespace omnimorph::python
