// The instruction sets for which batches are compiled and that the processor has, the best last.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bind.hpp"

namespace omnimorph::python {

namespace {

/// Whether the processor has one of them.
bool is_there(const std::string& instruction_set) {
#if defined(__x86_64__)
    const bool has_v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
    const bool has_v4 = has_v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                        __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                        __builtin_cpu_supports("avx512vl");
    return instruction_set == "x86-64-v4" ? has_v4 : instruction_set == "x86-64-v3" ? has_v3 : true;
#else
    return instruction_set == "portable";
#endif
}

std::vector<std::string> instruction_sets() {
    std::vector<std::string> there;
    for (const char* compiled : {OMNIMORPH_INSTRUCTION_SETS})
        if (is_there(compiled)) there.push_back(compiled);
    return there;
}

}  // namespace

void bind_processor(nb::module_& m) {
    m.def("instruction_sets", &instruction_sets);
}

}  // namespace omnimorph::python
