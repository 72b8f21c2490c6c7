// The rotor counts for which the loop is compiled on its own (CMakeLists.txt has the same list).
#pragma once

#include <type_traits>

namespace omnimorph::python {

/// Call `task` with the number of rotors as a constant; 0 for one that has no loop of its own.
template <class Task> auto with_rotors(int n, const Task& task) {
    switch (n) {
        case 4: return task(std::integral_constant<int, 4>());
        case 6: return task(std::integral_constant<int, 6>());
        case 8: return task(std::integral_constant<int, 8>());
        case 12: return task(std::integral_constant<int, 12>());
        default: return task(std::integral_constant<int, 0>());
    }
}

}  // namespace omnimorph::python
