// The rotor counts for which the loop is compiled on its own, OMNIMORPH_ROTOR_COUNTS, as CMakeLists.txt lists them; 0,
// the last of them, counts at run time.
#pragma once

#include <type_traits>

namespace omnimorph::python {

template <int First, int... Rest, class Task> auto with_one_of(int n, const Task& task) {
    if constexpr (sizeof...(Rest) == 0) {
        return task(std::integral_constant<int, First>());
    } else {
        return n == First ? task(std::integral_constant<int, First>()) : with_one_of<Rest...>(n, task);
    }
}

/// Call `task` with the number of rotors as a constant; with 0 for one that has no loop of its own.
template <class Task> auto with_rotors(int n, const Task& task) {
    return with_one_of<OMNIMORPH_ROTOR_COUNTS>(n, task);
}

}  // namespace omnimorph::python
